//! Rows of a table of indices that can be interpolated. A fault in a row that no study asks for
//! blocks no file: the faulty rows are left out, and the ranges between their sound neighbours are
//! remembered with the reason.

/// A range of wavelengths within which a table cannot be used.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Unusable {
    /// The neighbouring sound rows, nm; at an end of the table the faulty row itself.
    pub between_nm: [f64; 2],
    /// What is wrong there.
    pub reason: String,
}

impl Unusable {
    /// Whether a table with this range is of no use for wavelengths from `from` to `to`, nm.
    pub fn concerns(&self, [from, to]: [f64; 2]) -> bool {
        let [low, high] = self.between_nm;
        low < to && high > from
    }
}

/// A row as it stands in a file.
#[derive(Clone, Debug)]
pub struct FileRow<T> {
    /// Its wavelength, nm, if that can be read.
    pub nm: Option<f64>,
    /// Its other numbers, or what is wrong with them.
    pub values: Result<T, String>,
}

/// The sound rows in rising order, and the ranges that faulty ones leave.
#[derive(Clone, Debug, PartialEq)]
pub struct Usable<T> {
    /// Wavelength in nm and values of the sound rows.
    pub rows: Vec<(f64, T)>,
    /// Where there is none.
    pub gaps: Vec<Unusable>,
    /// The first fault, in the order of the file.
    pub first_fault: Option<String>,
}

/// Sorts out the rows of a table whose wavelengths rise or fall. A row is faulty if its numbers
/// are, if the order breaks there, or if another row has the same wavelength and other values.
/// Equal rows count once.
pub fn usable<T: Clone + PartialEq>(mut rows: Vec<FileRow<T>>) -> Usable<T> {
    let known: Vec<f64> = rows.iter().filter_map(|row| row.nm).collect();
    let steps = |falling: bool| known.windows(2).filter(|w| (w[1] < w[0]) == falling && w[0] != w[1]).count();
    let reversed = steps(true) > steps(false);
    let mut faults: Vec<Option<String>> = rows.iter().map(|row| row.values.clone().err()).collect();
    let mut first_fault = faults.iter().flatten().next().cloned();
    if reversed {
        rows.reverse();
        faults.reverse();
    }
    let mut blame = |places: [usize; 2], reason: String| {
        first_fault.get_or_insert_with(|| reason.clone());
        for place in places {
            faults[place].get_or_insert_with(|| reason.clone());
        }
    };
    for i in 1..rows.len() {
        let (Some(before), Some(here)) = (rows[i - 1].nm, rows[i].nm) else {
            // a row that cannot be placed makes both of its neighbours doubtful
            let reason = rows[i].values.clone().err().or_else(|| rows[i - 1].values.clone().err());
            blame([i - 1, i], reason.unwrap_or_else(|| "a row without a wavelength".to_owned()));
            continue;
        };
        if here < before {
            let [before, here] = if reversed { [here, before] } else { [before, here] };
            let way = if reversed { "fall" } else { "increase" };
            blame(
                [i - 1, i],
                format!("wavelengths do not {way}: {} nm after {} nm", tidy(here), tidy(before)),
            );
        }
    }
    let mut order: Vec<usize> = (0..rows.len()).filter(|&i| rows[i].nm.is_some()).collect();
    order.sort_by(|&a, &b| rows[a].nm.unwrap_or(0.0).total_cmp(&rows[b].nm.unwrap_or(0.0)));
    let mut kept: Vec<usize> = Vec::new();
    for i in order {
        if let Some(&last) = kept.last().filter(|&&last| rows[last].nm == rows[i].nm) {
            if rows[last].values == rows[i].values {
                continue;
            }
            let nm = tidy(rows[i].nm.unwrap_or(0.0));
            let reason = format!("wavelengths do not increase: two rows at {nm} nm with different values");
            first_fault.get_or_insert_with(|| reason.clone());
            for place in [last, i] {
                faults[place].get_or_insert_with(|| reason.clone());
            }
        }
        kept.push(i);
    }
    let (mut sound, mut gaps): (Vec<(f64, T)>, Vec<Unusable>) = (Vec::new(), Vec::new());
    let mut open: Option<Unusable> = None;
    for i in kept {
        let nm = rows[i].nm.unwrap_or(0.0);
        match (&faults[i], &rows[i].values) {
            (None, Ok(values)) => {
                if let Some(mut gap) = open.take() {
                    gap.between_nm[1] = nm;
                    gaps.push(gap);
                }
                sound.push((nm, values.clone()));
            }
            (fault, _) => {
                let from = sound.last().map_or(nm, |(nm, _)| *nm);
                let reason = fault.clone().unwrap_or_default();
                let gap = open.get_or_insert(Unusable { between_nm: [from, nm], reason });
                gap.between_nm[1] = nm;
            }
        }
    }
    gaps.extend(open);
    Usable { rows: sound, gaps, first_fault }
}

/// A wavelength without the rounding of a conversion from µm.
fn tidy(nm: f64) -> f64 {
    (1e6 * nm).round() / 1e6
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(rows: &[(f64, Option<f64>)]) -> Usable<f64> {
        let row = |&(nm, value): &(f64, Option<f64>)| FileRow {
            nm: Some(nm),
            values: value.ok_or_else(|| format!("bad at {nm}")),
        };
        usable(rows.iter().map(row).collect())
    }

    #[test]
    fn a_fault_costs_the_range_between_its_sound_neighbours() {
        let sound = table(&[(400.0, Some(1.0)), (500.0, Some(2.0)), (600.0, Some(3.0))]);
        assert_eq!((sound.rows.len(), &sound.gaps[..], &sound.first_fault), (3, &[][..], &None));
        // falling rows, and one that stands twice
        let falling =
            table(&[(600.0, Some(3.0)), (500.0, Some(2.0)), (500.0, Some(2.0)), (400.0, Some(1.0))]);
        assert_eq!(falling, sound);
        let bad = table(&[(400.0, Some(1.0)), (500.0, None), (600.0, Some(3.0)), (700.0, Some(4.0))]);
        assert_eq!(bad.rows, [(400.0, 1.0), (600.0, 3.0), (700.0, 4.0)]);
        let gap = &bad.gaps[0];
        assert_eq!((gap.between_nm, gap.reason.as_str(), bad.gaps.len()), ([400.0, 600.0], "bad at 500", 1));
        for (asked, concerned) in
            [([450.0, 450.0], true), ([600.0, 700.0], false), ([400.0, 400.0], false), ([300.0, 900.0], true)]
        {
            assert_eq!(gap.concerns(asked), concerned, "{asked:?}");
        }
    }

    #[test]
    fn what_is_ambiguous_is_not_used() {
        // two values at one wavelength, and 5500 typed for 550
        let twice = table(&[(400.0, Some(1.0)), (500.0, Some(2.0)), (500.0, Some(9.0)), (600.0, Some(3.0))]);
        assert_eq!(twice.rows, [(400.0, 1.0), (600.0, 3.0)]);
        assert!(twice.gaps[0].concerns([550.0, 550.0]) && twice.gaps[0].reason.contains("two rows at 500"));
        let typed = table(&[
            (500.0, Some(1.0)),
            (5500.0, Some(2.0)),
            (600.0, Some(3.0)),
            (650.0, Some(4.0)),
            (700.0, Some(5.0)),
        ]);
        assert!(typed.gaps.iter().any(|gap| gap.concerns([550.0, 550.0])), "{typed:?}");
        assert!(!typed.gaps.iter().any(|gap| gap.concerns([650.0, 700.0])), "{typed:?}");
        // the ends of a table
        let ends = table(&[(400.0, None), (500.0, Some(2.0)), (600.0, Some(3.0)), (700.0, None)]);
        assert_eq!(
            ends.gaps.iter().map(|gap| gap.between_nm).collect::<Vec<_>>(),
            [[400.0, 500.0], [600.0, 700.0]]
        );
        let lost = usable(vec![
            FileRow { nm: Some(400.0), values: Ok(1.0) },
            FileRow { nm: None, values: Err("unreadable".into()) },
            FileRow { nm: Some(500.0), values: Ok(2.0) },
            FileRow { nm: Some(600.0), values: Ok(3.0) },
        ]);
        assert_eq!(lost.rows, [(600.0, 3.0)]);
        assert_eq!(lost.first_fault.as_deref(), Some("unreadable"));
    }
}
