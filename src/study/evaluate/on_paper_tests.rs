use super::*;

/// Fits of few cells may become negative; at the normal nothing depends on the azimuth.
#[test]
fn the_directional_brdf_is_a_number_where_the_fit_is_negative() {
    let curve = AngleCurve { diffuse: [-0.01; DIFFUSE], ..AngleCurve::default() };
    let layer = LayerOnPaper::new(0, [0.5, 0.2], Measured::default(), curve, [0.8, 1.0]).unwrap();
    for [illumination, viewing] in [[1.0, 1.0], [1.0, 0.4], [0.3, 0.6]] {
        let f = layer.directional_brdf(illumination, viewing, 1.0);
        assert_eq!(f, layer.diffuse_brdf_at(illumination, viewing), "{illumination} {viewing}");
    }
}
