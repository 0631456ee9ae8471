//! Three-vectors and rotations: the few operations that packings need.

/// Cartesian components (x, y, z).
pub type V3 = [f64; 3];

/// a + b.
#[inline]
pub fn add(a: V3, b: V3) -> V3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// a − b.
#[inline]
pub fn sub(a: V3, b: V3) -> V3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// s a.
#[inline]
pub fn scale(a: V3, s: f64) -> V3 {
    [a[0] * s, a[1] * s, a[2] * s]
}

/// a · b.
#[inline]
pub fn dot(a: V3, b: V3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a × b.
#[inline]
pub fn cross(a: V3, b: V3) -> V3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// |a|.
#[inline]
pub fn norm(a: V3) -> f64 {
    dot(a, a).sqrt()
}

/// The unit vector along `a`, or the z axis when `a` vanishes.
#[inline]
pub fn unit(a: V3) -> V3 {
    let length = norm(a);
    if length > 0.0 { scale(a, 1.0 / length) } else { [0.0, 0.0, 1.0] }
}

/// A rotation as a unit quaternion (w, x, y, z).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Rotation(pub [f64; 4]);

impl Rotation {
    /// The identity rotation.
    pub const IDENTITY: Self = Self([1.0, 0.0, 0.0, 0.0]);

    /// The rotation by |a| radians about the direction of `a`.
    #[inline]
    pub fn by(a: V3) -> Self {
        let angle = norm(a);
        let (s, c) = (0.5 * angle).sin_cos();
        let k = if angle > 1e-12 { s / angle } else { 0.5 };
        Self([c, k * a[0], k * a[1], k * a[2]])
    }

    /// A rotation that carries the z axis onto the unit vector `axis`.
    #[inline]
    pub fn from_z_to(axis: V3) -> Self {
        if axis[2] < -1.0 + 1e-12 {
            return Self([0.0, 1.0, 0.0, 0.0]);
        }
        Self([1.0 + axis[2], -axis[1], axis[0], 0.0]).normalised()
    }

    /// Composition: first `self`, then `next`.
    #[inline]
    pub fn then(self, next: Self) -> Self {
        let ([aw, ax, ay, az], [bw, bx, by, bz]) = (next.0, self.0);
        Self([
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        ])
        .normalised()
    }

    /// The inverse rotation.
    #[inline]
    pub fn inverse(self) -> Self {
        let [w, x, y, z] = self.0;
        Self([w, -x, -y, -z])
    }

    /// The vector `v` after the rotation.
    #[inline]
    pub fn turn(self, v: V3) -> V3 {
        let [w, x, y, z] = self.0;
        let q = [x, y, z];
        let t = scale(cross(q, v), 2.0);
        add(v, add(scale(t, w), cross(q, t)))
    }

    #[inline]
    fn normalised(self) -> Self {
        let n = self.0.iter().map(|q| q * q).sum::<f64>().sqrt();
        Self(self.0.map(|q| q / n))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // Rounding budget: a handful of products of numbers below 2.
    const ROUNDING: f64 = 1e-14;

    #[test]
    fn a_quarter_turn_about_z_carries_x_to_y_and_turns_compose() {
        let quarter = Rotation::by([0.0, 0.0, std::f64::consts::FRAC_PI_2]);
        assert!(norm(sub(quarter.turn([1.0, 0.0, 0.0]), [0.0, 1.0, 0.0])) < ROUNDING);
        let about_x = Rotation::by([std::f64::consts::FRAC_PI_2, 0.0, 0.0]);
        let both = quarter.then(about_x).turn([1.0, 0.0, 0.0]);
        assert!(norm(sub(both, [0.0, 0.0, 1.0])) < ROUNDING);
    }

    #[test]
    fn the_turn_from_z_reaches_its_axis_even_at_the_south_pole() {
        for axis in [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0], unit([1.0, -2.0, 0.5]), unit([0.1, 0.2, -3.0])] {
            assert!(norm(sub(Rotation::from_z_to(axis).turn([0.0, 0.0, 1.0]), axis)) < ROUNDING);
        }
    }
}
