//! Weighted numbers.

use super::{Slip, slip};

/// The last line of the tiny study, behind which a number is added.
const END: &str = "picture_pixels = 61";

pub const NUMBER: &[Slip] = &[
    slip(
        END,
        "[[number]]\nname = \"sun\"\nof = \"albedo\"\nweights = \"sunlight\"",
        ["number[0].weights", "sunlight", "solar_g173, solar_g173_direct, erythema_g173", "weights.csv"],
    ),
    slip(
        END,
        "[[number]]\nname = \"sun\"\nof = \"albedo\"\nweights = \"solar_g173\"",
        [
            "number[0].weights",
            "% lie beyond the wavelengths, 400 to 700 nm",
            "at most 10 %",
            "from_nm and to_nm",
        ],
    ),
    slip(
        END,
        "[[number]]\nname = \"sun\"\nof = \"albedo\"\nweights = \"solar_g173\"\nfrom_nm = 3000",
        ["number[0].from_nm", "3000 to 2500 nm", "within 280 to 2500 nm", "leave them out"],
    ),
    slip(
        END,
        "[[number]]\nname = \"w\"\nof = \"lit_at_45\"\ntransform = \"whiteness\"\nweights = \"iso_visual\"",
        ["number[0].weights", "iso_visual", "\"D65/10\" or \"D65/2\"", "write weights = \"D65/10\""],
    ),
    slip(
        END,
        "[[number]]\nname = \"y\"\nof = \"lit_at_45\"\ntransform = \"yellowness\"\nweights = \"D50/2\"",
        ["number[0].weights", "D50/2", "\"C/2\", \"C/10\"", "write weights = \"D65/10\""],
    ),
    slip(
        END,
        "[[number]]\nname = \"d\"\nof = \"blackness\"\nweights = \"iso_visual\"",
        ["of", "blackness", "`albedo`, `natural_light`", "write one of these"],
    ),
    slip(
        END,
        "[[number]]\nname = \"d\"\nof = \"albedo\"\nweights = { csv = \"below.csv\" }",
        [
            "number[0].weights.csv",
            "row 2: a weight of -0.5 at 700 nm",
            "weight (0 or more)",
            "correct the file",
        ],
    ),
    slip(
        END,
        "[[number]]\nname = \"\"\nof = \"albedo\"\nweights = \"iso_visual\"",
        ["number[0].name", "\"\", a blank name", "a name with a letter or a digit", "name the number"],
    ),
];
