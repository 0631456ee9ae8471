//! Chooses one measurement of a file: by name or amounts of ink, by condition, by geometry. What is
//! left open is asked for, with the names of what there is.

use super::sample::{MeasuredFile, MeasuredSample, SampleContent};
use super::words::{MeasuredGeometry, MeasuredKind};
use super::{MeasuredCondition, MeasuredRequest, Patch};

/// Maximum number of names in a message.
const MOST_NAMES: usize = 12;
/// Rounding of amounts of ink as written, percent.
const DEVICE_ROUNDING: f64 = 0.02;

/// The measurement that is meant.
pub struct Chosen<'a> {
    /// It.
    pub sample: &'a MeasuredSample,
    /// Further colours of the same sample under other conditions.
    pub colours: Vec<&'a MeasuredSample>,
    /// Its place among the file's samples, from 1.
    pub place: usize,
    /// Number of samples in the file.
    pub samples: usize,
}

/// Names in words, at most some.
fn listed<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let mut all: Vec<&str> = Vec::new();
    for name in names.filter(|name| !name.is_empty()) {
        if all.len() <= MOST_NAMES && !all.contains(&name) {
            all.push(name);
        }
    }
    let shown = all.iter().take(MOST_NAMES).map(|name| format!("{name:?}")).collect::<Vec<_>>().join(", ");
    if all.len() > MOST_NAMES { shown + ", …" } else { shown }
}

/// Chooses a measurement.
///
/// # Errors
/// None is meant, or several are.
pub fn choose<'a>(file: &'a MeasuredFile, request: &MeasuredRequest) -> Result<Chosen<'a>, String> {
    let samples = &file.samples;
    let (places, count) = places(samples);
    let mut meant: Vec<usize> = match &request.patch {
        Some(patch) => named(samples, patch)?,
        // of colours alone one is the target
        None if count > 1
            && (request.one_must_be_named || samples.iter().all(|sample| sample.content.is_colour())) =>
        {
            let example = samples.iter().map(MeasuredSample::name).find(|name| !name.is_empty());
            let example = example.map_or(String::new(), |name| format!(", such as {name:?}"));
            return Err(format!("{count} samples, of which none is named: write compare.patch{example}"));
        }
        None => {
            // measurements of the first sample may be several objects of one name
            let title = samples.first().and_then(|first| first.names.first()).filter(|name| !name.is_empty());
            let is_first =
                |i: &usize| places[*i] == 1 || (title.is_some() && samples[*i].names.first() == title);
            (0..samples.len()).filter(is_first).collect()
        }
    };
    let name = meant.first().map_or("", |&i| samples[i].name());
    let called = if name.is_empty() { "the sample".to_owned() } else { format!("{name:?}") };
    // spectra of reflected light go before colours, which hold less
    let reflected: Vec<usize> = meant.iter().copied().filter(|&i| samples[i].kind == request.kind).collect();
    if reflected.is_empty()
        && let Some(&other) = meant.first()
    {
        let (found, wanted) = (samples[other].kind.name(), request.kind.name());
        let remedy = match request.kind {
            MeasuredKind::Transmittance => "name its column transmittance, if that is what it is",
            _ if matches!(samples[other].kind, MeasuredKind::Absorbance | MeasuredKind::KubelkaMunk) => {
                "give reflectance factors against wavelength, as instruments write them too"
            }
            _ => "measure it in reflection",
        };
        return Err(format!("{called} is {found}, not {wanted}: {remedy}"));
    }
    meant = reflected;
    let is_spectrum = |i: &usize| matches!(samples[*i].content, SampleContent::Spectrum(_));
    if meant.iter().any(is_spectrum) {
        meant.retain(is_spectrum);
    }
    by_condition(samples, &mut meant, &called, request.condition)?;
    by_geometry(samples, &mut meant, &called, &request.geometries)?;
    let Some(&first) = meant.first() else { return Err("no sample".into()) };
    let sample = &samples[first];
    let rest = || meant.iter().skip(1).map(|&i| &samples[i]);
    let mut colours: Vec<&MeasuredSample> = Vec::new();
    if sample.content.is_colour() {
        colours = rest().filter(|other| other.is_same_sample(sample)).collect();
    }
    let differs = |other: &MeasuredSample| match sample.content.is_colour() {
        true => !other.is_same_sample(sample),
        false => !same_values(&other.content, &sample.content),
    };
    if rest().any(differs) {
        let others = meant
            .iter()
            .flat_map(|&i| samples[i].names.iter())
            .map(String::as_str)
            .filter(|other| *other != name);
        let others = listed(others);
        let remedy = if others.is_empty() {
            "keep one of them, or give them different names".to_owned()
        } else {
            format!("write one of their other names as compare.patch: {others}")
        };
        return Err(format!("{} measurements of {called} that differ: {remedy}", meant.len()));
    }
    Ok(Chosen { sample, colours, place: places[first], samples: count })
}

/// The number of the sample that each measurement is of, from 1, and how many samples there are.
fn places(samples: &[MeasuredSample]) -> (Vec<usize>, usize) {
    let mut known = std::collections::HashMap::new();
    let mut places = Vec::with_capacity(samples.len());
    let mut count = 0;
    for sample in samples {
        let device: Vec<u64> = sample.device.iter().map(|value| value.to_bits()).collect();
        let is_known = sample.is_same_sample(sample);
        let place = match known.get(&(&sample.names, device.clone())) {
            Some(&place) if is_known => place,
            _ => {
                count += 1;
                known.insert((&sample.names, device), count);
                count
            }
        };
        places.push(place);
    }
    (places, count)
}

/// The measurements that a name or amounts of ink stand for.
fn named(samples: &[MeasuredSample], patch: &Patch) -> Result<Vec<usize>, String> {
    let with_device = |requested: &[f64]| -> Vec<usize> {
        let near = |sample: &MeasuredSample| {
            sample.device.len() == requested.len()
                && sample
                    .device
                    .iter()
                    .zip(requested)
                    .all(|(value, target)| (value - target).abs() <= DEVICE_ROUNDING)
        };
        (0..samples.len()).filter(|&i| near(&samples[i])).collect()
    };
    let name = patch.to_string();
    let requested = match patch {
        Patch::Inks(requested) => {
            let found = with_device(requested);
            if !found.is_empty() {
                return Ok(found);
            }
            let stated = samples.iter().map(|sample| &sample.device).find(|device| !device.is_empty());
            return Err(match stated {
                Some(device) => {
                    format!("no sample with the device values {requested:?}; the first has {device:?}")
                }
                None => format!("no sample with the device values {requested:?}: the file states none"),
            });
        }
        Patch::Name(_) | Patch::Number(_) => name.trim(),
    };
    let ranks = samples.iter().map(|sample| sample.names.len()).max().unwrap_or(0);
    for rank in 0..ranks {
        let is = |i: &usize| samples[*i].names.get(rank).is_some_and(|name| name == requested);
        let found: Vec<usize> = (0..samples.len()).filter(is).collect();
        if !found.is_empty() {
            return Ok(found);
        }
    }
    let numbers: Option<Vec<f64>> = requested
        .split(|c: char| c.is_whitespace() || matches!(c, ',' | '/' | ';'))
        .map(|part| part.trim_start_matches(|c: char| c.is_alphabetic() || c == '='))
        .filter(|part| !part.is_empty())
        .map(|part| part.parse().ok())
        .collect();
    let found =
        numbers.filter(|numbers| numbers.len() > 2).map(|numbers| with_device(&numbers)).unwrap_or_default();
    if !found.is_empty() {
        return Ok(found);
    }
    let unnamed = samples.iter().all(|sample| sample.name().is_empty());
    if unnamed
        && let Ok(number) = requested.parse::<usize>()
        && (1..=samples.len()).contains(&number)
    {
        return Ok(vec![number - 1]);
    }
    let found = listed(samples.iter().map(MeasuredSample::name));
    let found = match (found.is_empty(), samples.len()) {
        (true, 1) => "no names".to_owned(),
        (true, count) => format!("no names: \"1\" to \"{count}\" select by place"),
        _ => found,
    };
    Err(format!("no sample {requested:?}; found {found}"))
}

/// Keeps the measurements under the requested condition, or the only one.
fn by_condition(
    samples: &[MeasuredSample],
    meant: &mut Vec<usize>,
    called: &str,
    requested: Option<MeasuredCondition>,
) -> Result<(), String> {
    let mut conditions: Vec<Option<MeasuredCondition>> = Vec::new();
    for &i in meant.iter() {
        if !conditions.contains(&samples[i].condition) {
            conditions.push(samples[i].condition);
        }
    }
    let name =
        |condition: &Option<MeasuredCondition>| condition.map_or("none stated", MeasuredCondition::name);
    let names = conditions.iter().map(name).collect::<Vec<_>>().join(", ");
    match requested {
        Some(_) if conditions.contains(&requested) => {
            meant.retain(|&i| samples[i].condition == requested);
            Ok(())
        }
        Some(requested) => {
            let remedy = if conditions == [None] { "; leave the condition out" } else { "" };
            Err(format!("{called} has no measurement under {}; found: {names}{remedy}", requested.name()))
        }
        None if conditions.len() > 1 => {
            let example = conditions.iter().flatten().next().map_or("M0", |condition| condition.name());
            Err(format!(
                "{} measurements of {called} under the conditions {names}: choose by compare.condition = {example:?}",
                meant.len()
            ))
        }
        None => Ok(()),
    }
}

/// Keeps the measurements of an allowed geometry; those that state none are taken where no other
/// is.
fn by_geometry(
    samples: &[MeasuredSample],
    meant: &mut Vec<usize>,
    called: &str,
    allowed: &[MeasuredGeometry],
) -> Result<(), String> {
    if allowed.is_empty() {
        return Ok(());
    }
    let is_allowed =
        |i: &usize| samples[*i].geometry.as_ref().is_some_and(|geometry| allowed.contains(geometry));
    if meant.iter().any(is_allowed) {
        meant.retain(is_allowed);
        return Ok(());
    }
    let other = meant.iter().find_map(|&i| samples[i].geometry.as_ref());
    if meant.iter().any(|&i| samples[i].geometry.is_none()) {
        meant.retain(|&i| samples[i].geometry.is_none());
        return Ok(());
    }
    let Some(other) = other else { return Ok(()) };
    let allowed = allowed.iter().map(MeasuredGeometry::name).collect::<Vec<_>>().join(" or ");
    Err(format!(
        "{called} is measured with the geometry {}; what is predicted is {allowed}: each holds light that the others do not",
        other.name()
    ))
}

fn same_values(one: &SampleContent, other: &SampleContent) -> bool {
    match (one, other) {
        (SampleContent::Spectrum(one), SampleContent::Spectrum(other)) => {
            one.len() == other.len()
                && one.iter().zip(other).all(|(a, b)| a.nm == b.nm && a.value.text == b.value.text)
        }
        (one, other) => one == other,
    }
}
