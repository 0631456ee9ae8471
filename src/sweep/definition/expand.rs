//! Expands axes into variants: products and zips, minus exclusions, plus overrides.

use super::axes::{Axis, names};
use super::file::{SweepFile, Where};
use crate::input::fault::{Fault, Faults};
use crate::input::field;
use toml::Table;

/// Maximum number of variants of a sweep.
const MOST_VARIANTS: usize = 100_000;

/// Maximum length of a variant's name, bytes: file systems allow 255, and temporary files add a
/// few.
const LONGEST_NAME: usize = 200;

/// A variant that has not been checked yet.
#[derive(Clone, Debug, PartialEq)]
pub struct Draft {
    /// Name made of the labels, suitable for files.
    pub name: String,
    /// Index of the setting on each axis.
    pub place: Vec<usize>,
    /// The study of the variant as a table, with the title of the sweep and the labels.
    pub study: Table,
}

/// All variants in the order of the axes; the last axis varies fastest.
pub fn expand(file: &SweepFile, base: &Table, axes: &[Axis], faults: &mut Faults) -> Vec<Draft> {
    for (i, axis) in axes.iter().enumerate() {
        // one that has none is reported already
        let is_named = file.axis[i].name.is_some() || file.axis[i].field.is_some();
        let others = axes[..i].iter().map(|earlier| earlier.name.as_str());
        if is_named {
            faults.name(format!("axis[{i}].name"), &axis.name, others, "axis");
        }
        // the later would override the earlier, whose captions would be wrong
        if let Some(field) = &file.axis[i].field
            && file.axis[..i].iter().any(|earlier| earlier.field.as_ref() == Some(field))
        {
            let remedy = "keep one of them, with all values";
            faults.add(format!("axis[{i}].field"), format!("{field} twice"), "a field of one axis", remedy);
        }
    }
    for (i, exclude) in file.exclude.iter().enumerate() {
        check_where(&format!("exclude[{i}].where"), &exclude.condition, axes, faults);
    }
    for (i, rule) in file.overrides.iter().enumerate() {
        check_where(&format!("override[{i}].where"), &rule.condition, axes, faults);
        if rule.set.is_empty() {
            let remedy = "name the fields to set, such as { \"run.seed\" = 2 }, or remove the override";
            faults.add(format!("override[{i}].set"), "nothing", "one field or more", remedy);
        }
    }
    let places = places(axes, faults);
    if !faults.0.is_empty() {
        return Vec::new();
    }
    let kept = |place: &Vec<usize>| !file.exclude.iter().any(|e| matches(&e.condition, axes, place));
    let drafts: Vec<Draft> =
        places.into_iter().filter(kept).map(|place| draft(file, base, axes, place, faults)).collect();
    check_names(&drafts, faults);
    drafts
}

/// Whether a variant satisfies a condition.
pub fn matches(condition: &Where, axes: &[Axis], place: &[usize]) -> bool {
    condition.iter().all(|(name, selected)| {
        let axis = axes.iter().position(|axis| axis.name == *name);
        axis.is_some_and(|a| axes[a].matching(selected).contains(&place[a]))
    })
}

/// Checks that a condition names existing axes and values.
pub fn check_where(field: &str, condition: &Where, axes: &[Axis], faults: &mut Faults) {
    for (name, selected) in condition {
        let field = format!("{field}.{name}");
        match axes.iter().find(|axis| axis.name == *name) {
            None => {
                faults.add(field, format!("{name:?}"), names(axes), "name one of the axes");
            }
            Some(axis) if axis.matching(selected).is_empty() => {
                let labels: Vec<&str> = axis.settings.iter().map(|s| s.label.as_str()).collect();
                let allowed = format!("one of {}", labels.join(", "));
                faults.add(field, selected, allowed, "name a label or value of the axis");
            }
            Some(_) => {}
        }
    }
}

/// All combinations of the groups of axes.
fn places(axes: &[Axis], faults: &mut Faults) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for (a, axis) in axes.iter().enumerate() {
        match groups.iter_mut().find(|group| axis.zip.is_some() && axes[group[0]].zip == axis.zip) {
            Some(group) => group.push(a),
            None => groups.push(vec![a]),
        }
    }
    let lengths: Vec<usize> = groups.iter().map(|group| axes[group[0]].settings.len()).collect();
    for (group, length) in groups.iter().zip(&lengths) {
        if let Some(&odd) = group.iter().find(|&&a| axes[a].settings.len() != *length) {
            let found = format!("{} values", axes[odd].settings.len());
            let allowed = format!("{length} values, as its zipped axis {:?}", axes[group[0]].name);
            faults.add(format!("axis[{odd}].zip"), found, allowed, "make the lists equally long");
        }
    }
    for &a in groups.iter().filter(|group| group.len() == 1).flatten() {
        if let Some(zip) = &axes[a].zip {
            let allowed = "a name that two axes or more have, which then vary together";
            let remedy = "give another axis this zip, or remove it";
            faults.add(format!("axis[{a}].zip"), format!("{zip:?} of one axis"), allowed, remedy);
        }
    }
    let count = lengths.iter().try_fold(1usize, |all, &n| all.checked_mul(n)).unwrap_or(usize::MAX);
    if count > MOST_VARIANTS {
        let allowed = format!("at most {MOST_VARIANTS} combinations");
        faults.add("axis", format!("{count} combinations"), allowed, "shorten the axes");
    }
    if !faults.0.is_empty() {
        return Vec::new();
    }
    (0..count).map(|n| place(n, axes.len(), &groups, &lengths)).collect()
}

fn place(mut n: usize, axes: usize, groups: &[Vec<usize>], lengths: &[usize]) -> Vec<usize> {
    let mut place = vec![0; axes];
    for (group, length) in groups.iter().zip(lengths).rev() {
        group.iter().for_each(|&a| place[a] = n % length);
        n /= length;
    }
    place
}

fn draft(file: &SweepFile, base: &Table, axes: &[Axis], place: Vec<usize>, faults: &mut Faults) -> Draft {
    let mut study = base.clone();
    let settings = axes.iter().zip(&place).enumerate();
    let of_axes = settings.map(|(a, (axis, &k))| (format!("axis[{a}].field"), &axis.settings[k].set));
    let rules = file.overrides.iter().enumerate().filter(|(_, r)| matches(&r.condition, axes, &place));
    for (at, fields) in of_axes.chain(rules.map(|(i, rule)| (format!("override[{i}].set"), &rule.set))) {
        for (name, value) in fields {
            if let Err(reason) = field::set(&mut study, name, value) {
                let fault = Fault::new(&at, name, format!("fields of a study; {reason}"), "correct the name");
                if !faults.0.contains(&fault) {
                    faults.push(fault);
                }
            }
        }
    }
    let labels = axes.iter().zip(&place).map(|(axis, &k)| axis.settings[k].label.as_str());
    let labels: Vec<&str> = labels.collect();
    let title = file.title.as_deref().unwrap_or_default();
    let caption = labels.join(", ");
    let title = if caption.is_empty() { title.to_owned() } else { format!("{title}: {caption}") };
    study.insert("title".into(), title.into());
    let name = labels.into_iter().map(slug).collect::<Vec<_>>().join("-");
    Draft { name: if name.is_empty() { "study".into() } else { name }, place, study }
}

/// Keeps letters, digits, dots and underscores; replaces everything else by one underscore. A minus
/// becomes a word: a folder whose name begins with one would pass for an option.
fn slug(label: &str) -> String {
    if let Some(number) = label.strip_prefix('-').filter(|number| number.parse::<f64>().is_ok()) {
        return format!("minus{}", slug(number));
    }
    let kept = |c: char| match c {
        'µ' => 'u',
        c if c.is_ascii_alphanumeric() || ".+".contains(c) => c,
        _ => '_',
    };
    let text: String = label.chars().map(kept).collect();
    text.split('_').filter(|part| !part.is_empty()).collect::<Vec<_>>().join("_")
}

/// Whether a name is that of a single folder, on every operating system.
pub fn is_folder_name(name: &str) -> bool {
    let speaks = name.chars().any(|c| c.is_ascii_alphanumeric());
    speaks && name.chars().all(|c: char| c.is_ascii_alphanumeric() || "._+-".contains(c))
}

fn check_names(drafts: &[Draft], faults: &mut Faults) {
    let mut names: Vec<&str> = drafts.iter().map(|d| d.name.as_str()).collect();
    if let Some(name) = names.iter().find(|name| name.len() > LONGEST_NAME) {
        let found = format!("labels that give a name of {} characters", name.len());
        let allowed = format!("at most {LONGEST_NAME}: it is the name of the variant's folder");
        faults.add("axis", found, allowed, "shorten the labels, as with labels = [\"a\", \"b\"]");
    }
    if let Some(name) = names.iter().find(|name| !is_folder_name(name)) {
        let allowed = "a label with a letter or digit: it is the name of the variant's folder";
        faults.add("axis", format!("label {name:?}"), allowed, "give the axis labels = [\"a\", \"b\"]");
    }
    names.sort_unstable();
    if let Some(pair) = names.windows(2).find(|pair| pair[0] == pair[1]) {
        let remedy = "give the axes labels that differ in their letters and digits";
        faults.add("axis", format!("{:?} twice", pair[0]), "variants with different names", remedy);
    }
    if drafts.is_empty() && faults.0.is_empty() {
        faults.add("exclude", "every variant", "exclusions that leave some", "remove an exclusion");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Variants of a number and of its negative are two folders, neither of which passes for an
    /// option. *Planted*: the minus left out of the name.
    #[test]
    fn numbers_of_either_sign_name_folders_of_their_own() {
        let labels = ["30", "-30", "0.1", "-0.1", "-1e-3"];
        let names = labels.map(slug);
        assert_eq!(names, ["30", "minus30", "0.1", "minus0.1", "minus1e_3"]);
        assert!(names.iter().all(|name| is_folder_name(name)));
        assert_eq!(slug("-yellow"), "yellow");
    }
}
