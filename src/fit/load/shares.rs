//! Shares of a drawdown's pigments: by volume, or by weight with densities.

use crate::fit::file::MeasuredTable;
use crate::input::fault::Fault;
use crate::input::limits::DENSITY;
use std::collections::BTreeMap;
use toml::{Table, Value};

/// The name of the binder among weights and densities.
pub(super) const BINDER: &str = "binder";

/// Shares of the base's pigments in a drawdown's volume.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Shares {
    /// The key that gives them; none where they are those of the base.
    pub key: Option<&'static str>,
    /// Share by the place of the pigment in the base; none where it is that of the base.
    pub of_volume: Vec<Option<f64>>,
}

impl Shares {
    /// The shares of a drawdown. `names` are the base's pigments, that with the unknown index
    /// first.
    ///
    /// # Errors
    /// A name that is no pigment, a negative part, weights without densities or without a binder,
    /// shares by two keys, or none of the pigment whose index is unknown.
    pub fn of(
        field: &str,
        table: &MeasuredTable,
        densities: &BTreeMap<String, f64>,
        names: &[String],
    ) -> Result<Self, Fault> {
        let (key, parts) = match (&table.volume_fractions, &table.weights) {
            (None, None) => return Ok(Self::default()),
            (Some(_), Some(_)) => {
                let remedy = "remove one of them";
                return Err(Fault::new(
                    format!("{field}.weights"),
                    "both",
                    "weights or volume_fractions",
                    remedy,
                ));
            }
            (Some(parts), None) => ("volume_fractions", parts),
            (None, Some(parts)) => ("weights", parts),
        };
        let of = |name: &str| format!("{field}.{key}.{name}");
        if let Some(share) = table.volume_fraction {
            let allowed = format!("none beside {key}");
            let remedy = format!("remove it: {key} names the pigment as well");
            return Err(Fault::new(format!("{field}.volume_fraction"), share, allowed, remedy));
        }
        let is_known = |name: &String| names.contains(name) || (key == "weights" && name == BINDER);
        if let Some(name) = parts.keys().find(|name| !is_known(name)) {
            let allowed = format!("the names of the base's pigments: {}", names.join(", "));
            return Err(Fault::new(of(name), "a share", allowed, "name a pigment of the base"));
        }
        if let Some((name, part)) = parts.iter().find(|(_, part)| !(part.is_finite() && **part >= 0.0)) {
            return Err(Fault::new(of(name), part, "a number of 0 or more", "0 where it is not there"));
        }
        let share = |name: &String| parts.get(name).copied();
        let of_volume: Vec<Option<f64>> = if key == "weights" {
            let volumes = volumes(field, parts, densities)?;
            let sum: f64 = volumes.values().sum();
            if sum <= 0.0 {
                let remedy = "write parts by weight, such as { red = 3, binder = 40 }";
                return Err(Fault::new(format!("{field}.weights"), "0 in all", "more than 0 in all", remedy));
            }
            names
                .iter()
                .map(|name| Some(volumes.get(name.as_str()).map_or(0.0, |volume| volume / sum)))
                .collect()
        } else {
            names.iter().map(share).collect()
        };
        if of_volume.first().is_some_and(|own| *own == Some(0.0)) {
            let allowed = "more than 0 of the pigment whose index is unknown";
            let remedy = "remove this spectrum: it says nothing of that pigment";
            return Err(Fault::new(of(&names[0]), 0.0, allowed, remedy));
        }
        Ok(Self { key: Some(key), of_volume })
    }
}

/// Volumes of parts by weight: w/ρ.
fn volumes<'a>(
    field: &str,
    weights: &'a BTreeMap<String, f64>,
    densities: &BTreeMap<String, f64>,
) -> Result<BTreeMap<&'a str, f64>, Fault> {
    if !weights.contains_key(BINDER) {
        let remedy = "write the weight of the dry binder, such as binder = 40";
        return Err(Fault::new(
            format!("{field}.weights.{BINDER}"),
            "nothing",
            "the part of the binder",
            remedy,
        ));
    }
    let volume = |(name, weight): (&'a String, &f64)| {
        let density = densities.get(name).copied().ok_or_else(|| {
            let remedy = "weights become volumes by densities: add it, such as { red = 5.2, white = 4.2, binder = 1.1 }, or give volume_fractions";
            let allowed = format!("its density, {DENSITY}");
            Fault::new(format!("fit.densities_g_per_cm3.{name}"), "nothing", allowed, remedy)
        })?;
        Ok((name.as_str(), weight / density))
    };
    weights.iter().map(volume).collect()
}

/// Sets the shares in a base, removes pigments without any, and gives the places in it of those
/// that stay.
pub(super) fn without_absent(base: &mut Table, shares: &Shares) -> Vec<usize> {
    let Some(Value::Array(pigments)) = base.get_mut("pigment") else { return Vec::new() };
    let mut places: Vec<usize> = (0..pigments.len()).collect();
    for (pigment, share) in pigments.iter_mut().zip(&shares.of_volume) {
        if let (Value::Table(pigment), Some(share)) = (pigment, share) {
            pigment.insert("volume_fraction".into(), (*share).into());
        }
    }
    let is_absent = |place: &usize| shares.of_volume.get(*place) == Some(&Some(0.0));
    places.retain(|place| !is_absent(place));
    let kept = places.iter().map(|&place| pigments[place].clone()).collect();
    *pigments = kept;
    places
}
