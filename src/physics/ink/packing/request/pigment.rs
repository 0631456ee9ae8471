//! The grains of one pigment, as requested.

use crate::ink::{Agglomeration, Orientation, PackError, Shape, SizeDistribution};
#[cfg(feature = "serde")]
use crate::numerics::files::name_or_table;
use crate::numerics::vector::V3;

/// The grains of one pigment.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct PigmentGrains {
    /// Shape of the grains.
    #[cfg_attr(feature = "serde", serde(default, deserialize_with = "name_or_table"))]
    pub shape: Shape,
    /// Distribution of their sizes.
    pub size: SizeDistribution,
    /// Thicknesses of the layers around the core of every grain, from the core outwards, nm; they
    /// belong to the grain: its size and volume include them.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Vec::is_empty"))]
    pub shell_nm: Vec<f64>,
    /// Union volume of the grains over the volume of the layer (with relief: over the dry volume,
    /// see [`crate::ink::Relief`]).
    pub volume_fraction: f64,
    /// Alignment of their axes.
    #[cfg_attr(feature = "serde", serde(default, deserialize_with = "name_or_table"))]
    pub orientation: Orientation,
    /// Agglomeration of the grains, if any.
    #[cfg_attr(feature = "serde", serde(default))]
    pub agglomeration: Option<Agglomeration>,
    /// Rule by which a number of whole grains meets the volume fraction.
    ///
    /// Grains of one size: the nearest number. With a spread of sizes, the number is the requested
    /// volume over the mean grain volume of the distribution, its fractional part rounded at
    /// random, with one size drawn from each of as many equal fractions of the distribution. Over
    /// many cells, number, sizes and volume are unbiased, though a small cell may hold more or less
    /// (reported).
    #[cfg_attr(feature = "serde", serde(default))]
    pub share: ShareRule,
    /// Where along the depth the grains are: rows of depth over thickness, 0 to 1, and density,
    /// linear in between; evenly without any. Only ratios of densities matter.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Vec::is_empty"))]
    pub profile: Vec<[f64; 2]>,
    /// Optic axis in the frame of a grain, of any length above 0, if the pigment is birefringent.
    /// That of a convex body turns with it, that of a union of spheres about the union's axis at
    /// random; a sphere has no frame, and its axis is drawn as `orientation` aligns them.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub optic_axis: Option<V3>,
}

impl PigmentGrains {
    /// Spheres of one diameter.
    pub fn spheres(diameter_nm: f64, volume_fraction: f64) -> Self {
        Self::of(Shape::Sphere, diameter_nm, volume_fraction)
    }

    /// Grains of one shape and one effective diameter.
    pub fn of(shape: Shape, effective_diameter_nm: f64, volume_fraction: f64) -> Self {
        Self {
            shape,
            size: SizeDistribution::diameter_nm(effective_diameter_nm),
            shell_nm: Vec::new(),
            volume_fraction,
            orientation: Orientation::Random,
            agglomeration: None,
            share: ShareRule::NearestGrain,
            profile: Vec::new(),
            optic_axis: None,
        }
    }
}

/// Rule by which a number of whole grains meets a volume fraction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum ShareRule {
    /// The number of grains whose expected volume is nearest; the remainder is reported.
    #[default]
    NearestGrain,
    /// The nearest number, with all sizes multiplied by the factor that makes the fraction exact
    /// (also reported).
    ScaleSizes,
}

/// Checks the numbers of the `k`-th pigment.
pub(super) fn check_pigment(k: usize, pigment: &PigmentGrains) -> Result<(), PackError> {
    let share = pigment.volume_fraction;
    let field = format!("pigment[{k}].volume_fraction");
    let remedy = "give a fraction of the layer's volume, not a percentage";
    PackError::unless((0.0..=1.0).contains(&share), field, share, "0 to 1", remedy)?;
    let fractal = pigment.agglomeration.as_ref().is_some_and(|rule| rule.fractal.is_some());
    let field = format!("pigment[{k}].agglomeration.fractal");
    let found = format!("`fractal` with the shape {}", pigment.shape.name());
    let allowed = "fractal agglomerates of grains made of spheres";
    let remedy = "leave `fractal` out, or take `sphere`, `cylinder` or `beaded_ellipsoid`";
    PackError::unless(!fractal || pigment.shape.form().is_none(), field, found, allowed, remedy)?;
    let agglomeration = pigment.agglomeration.as_ref().and_then(Agglomeration::defect);
    let defects = [
        pigment.shape.defect(),
        pigment.size.defect(),
        pigment.orientation.defect(),
        agglomeration,
        profile_defect(pigment),
    ];
    match defects.into_iter().flatten().next() {
        None => pigment.check_layers(k),
        Some((field, found, allowed)) => {
            Err(PackError::input(format!("pigment[{k}].{field}"), found, allowed, "correct this entry"))
        }
    }
}

/// What is wrong with the rows of a profile: field, value and what is allowed.
fn profile_defect(pigment: &PigmentGrains) -> Option<(&'static str, String, &'static str)> {
    let rows = &pigment.profile;
    let (first, last) = rows.first().zip(rows.last())?;
    let allowed = "rows [depth, share] from depth 0 to depth 1, in order, with shares from 0 to 0.64 that are not all 0";
    let is_sound =
        |[depth, share]: &[f64; 2]| (0.0..=1.0).contains(depth) && share.is_finite() && *share >= 0.0;
    let is_whole = rows.len() >= 2 && first[0] == 0.0 && last[0] == 1.0;
    let rises = rows.windows(2).all(|pair| pair[1][0] >= pair[0][0]);
    let good = is_whole && rises && rows.iter().all(is_sound) && rows.iter().any(|row| row[1] > 0.0);
    (!good).then(|| ("profile", format!("{rows:?}"), allowed))
}
