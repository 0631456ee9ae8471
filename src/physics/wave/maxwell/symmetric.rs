//! Symmetric tensors of three dimensions.

use num_complex::Complex64;

/// Components xx, xy, yy, xz, yz, zz of a symmetric tensor.
pub type Symmetric = [Complex64; 6];

/// Adjugate and determinant of a symmetric tensor.
pub fn adjugate(&[xx, xy, yy, xz, yz, zz]: &Symmetric) -> (Symmetric, Complex64) {
    let a = yy * zz - yz * yz;
    let b = xz * yz - xy * zz;
    let c = xx * zz - xz * xz;
    let d = xy * yz - xz * yy;
    let e = xy * xz - xx * yz;
    let f = xx * yy - xy * xy;
    ([a, b, c, d, e, f], xx * a + xy * b + xz * d)
}

/// Symmetric part of A B.
pub fn symmetric_product(a: &Symmetric, b: &Symmetric) -> Symmetric {
    let full = |&[xx, xy, yy, xz, yz, zz]: &Symmetric| [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
    let full_a = full(a);
    let full_b = full(b);
    let entry = |i: usize, j: usize| (0..3).map(|k| full_a[i][k] * full_b[k][j]).sum::<Complex64>();
    let symmetric = |i: usize, j: usize| 0.5 * (entry(i, j) + entry(j, i));
    [symmetric(0, 0), symmetric(0, 1), symmetric(1, 1), symmetric(0, 2), symmetric(1, 2), symmetric(2, 2)]
}
