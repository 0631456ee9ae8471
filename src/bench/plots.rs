//! The plots of a comparison: cost against the period for each pigment of a matrix, or error
//! against cost for a single case.

use super::page::Comparison;
use super::row::{Row, grouped, mean_name, scheme_name};
use crate::draw::chart::{Chart, Curve, Style};
use crate::wave::Scheme;

/// Processor time that Linux counts, s: less is drawn there.
const LEAST_SECONDS: f64 = 1e-3;

/// What distinguishes the curves of one strategy.
type MeanVariant = (Option<Scheme>, bool);

impl Comparison {
    /// File names and plots that have something to show, and the titles of those that have nothing.
    pub(super) fn plots(&self) -> (Vec<(String, Chart)>, Vec<String>) {
        let plots = match self.has_cases() {
            true if !self.cases.is_empty() => self.of_named_cases(),
            true => self.applications(),
            false => self.of_one_case(),
        };
        let (empty, shown): (Vec<_>, Vec<_>) = plots.into_iter().partition(|(_, plot)| plot.is_empty());
        (shown, empty.into_iter().map(|(_, plot)| plot.title).collect())
    }

    /// Applications against the period, one plot for each pigment; lines are broken where a
    /// strategy fails.
    fn applications(&self) -> Vec<(String, Chart)> {
        let mut pigments: Vec<[f64; 2]> =
            self.rows.iter().filter_map(|row| row.case).map(|case| case.pigment).collect();
        pigments.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        pigments.dedup();
        let plots = pigments.into_iter().enumerate();
        plots.map(|(k, pigment)| (format!("applications-{}.svg", k + 1), self.of_pigment(pigment))).collect()
    }

    fn of_pigment(&self, pigment: [f64; 2]) -> Chart {
        let rows: Vec<&Row> =
            self.rows.iter().filter(|row| row.case.is_some_and(|case| case.pigment == pigment)).collect();
        let curves = self.curves(&rows, |row| [row.case.map_or(f64::NAN, |c| c.period_um), counted(row)]);
        let title = format!("Pigment {} + {}i", pigment[0], pigment[1]);
        Chart::log_log(&title, "period, µm", "operator applications", curves)
    }

    /// Error against processor seconds, for each case file one plot of programs, whose seconds are
    /// those of whole processes, and one of strategies, whose seconds are those of a solve alone.
    fn of_named_cases(&self) -> Vec<(String, Chart)> {
        let mut plots = Vec::new();
        for (k, [name, ..]) in self.cases.iter().enumerate() {
            let title =
                |what: &str| if self.externals.is_empty() { name.clone() } else { format!("{name}: {what}") };
            let processes =
                self.of_case(name, true, title("whole processes"), "processor seconds of the whole process");
            let solves =
                self.of_case(name, false, title("solves alone"), "processor seconds of the solve alone");
            plots.push((format!("error_against_cpu_seconds-{}.svg", k + 1), processes));
            plots.push((format!("error_against_solve_seconds-{}.svg", k + 1), solves));
        }
        plots
    }

    fn of_case(&self, name: &String, of_processes: bool, title: String, cost: &str) -> Chart {
        let of_this_case = |row: &&Row| row.named.as_ref() == Some(name) && row.converged();
        let rows: Vec<&Row> = self
            .rows
            .iter()
            .filter(of_this_case)
            .filter(|row| self.is_process(row) == of_processes)
            .collect();
        let curves = self.curves(&rows, |row| {
            [row.processor_seconds.or(row.seconds).unwrap_or(f64::NAN).max(LEAST_SECONDS), error(row)]
        });
        Chart::log_log(&title, cost, "largest amplitude error", curves)
    }

    fn of_one_case(&self) -> Vec<(String, Chart)> {
        let all: Vec<&Row> = self.rows.iter().filter(|row| row.converged()).collect();
        let work = |row: &Row| (row.applications() * row.unknowns.unwrap_or(0)) as f64;
        let work = self.curves(&all, |row| [work(row), error(row)]);
        let seconds = self.curves(&all, |row| [row.seconds.unwrap_or(f64::NAN), error(row)]);
        let of_error = |name: &str, title: &str, cost: &str, curves| {
            (format!("{name}.svg"), Chart::log_log(title, cost, "largest amplitude error", curves))
        };
        vec![
            ("residuals.svg".into(), self.residual_plot()),
            of_error("error_against_work", "Error against work", "applications × unknowns", work),
            of_error("error_against_seconds", "Error against time", "seconds", seconds),
        ]
    }

    /// Residuals on the finest grid of every scheme and mean.
    fn residual_plot(&self) -> Chart {
        let finest = self.rows.iter().filter_map(|row| row.unknowns).max();
        let rows: Vec<&Row> = self.rows.iter().filter(|row| row.unknowns == finest).collect();
        // The start, before any application, would not show on a logarithmic axis.
        let histories = rows.iter().map(|row| {
            let shown = row.looks().into_iter().filter(|look| look.0 > 0.0);
            self.looking(Curve::new(label(row, &rows), Style::Data, shown), row, &rows)
        });
        let histories = histories.filter(|curve| !curve.points.is_empty()).collect();
        let words = ["Residual on the finest grid", "operator applications", "relative residual"];
        Chart { log: [false, true], ..Chart::log_log(words[0], words[1], words[2], histories) }
    }

    /// One curve for each strategy, scheme and mean; where a value is not finite, the line is
    /// broken.
    fn curves(&self, rows: &[&Row], point: impl Fn(&Row) -> [f64; 2]) -> Vec<Curve> {
        let groups = grouped(rows.iter().copied(), |row| label(row, rows)).into_iter();
        let curves = groups.map(|(name, group)| {
            let points = group.iter().map(|row| point(row).into());
            self.looking(Curve::new(name, Style::Data, points), group[0], rows)
        });
        curves.filter(|curve| curve.points.iter().any(|p| p[0] > 0.0 && p[1] > 0.0)).collect()
    }

    /// One colour and one marker for a strategy over the whole page; dashes tell its schemes and
    /// means apart.
    fn looking(&self, curve: Curve, row: &Row, rows: &[&Row]) -> Curve {
        let mut names = self.registry.iter().chain(&self.externals);
        let place = names.position(|name| *name == row.strategy).unwrap_or(self.registry.len());
        let dashes = variants(rows).iter().position(|other| *other == variant(row)).unwrap_or(0);
        curve.looking(place, place).dashed(dashes)
    }
}

fn variant(row: &Row) -> MeanVariant {
    (row.discrete.map(|d| d.resolution.scheme), row.discrete.is_some_and(|d| d.absorbing_mean))
}

/// Schemes and means of some rows, in their order.
fn variants(rows: &[&Row]) -> Vec<MeanVariant> {
    grouped(rows.iter().copied(), variant).into_iter().map(|(variant, _)| variant).collect()
}

/// The strategy, with scheme and mean where the rows differ in them.
fn label(row: &Row, rows: &[&Row]) -> String {
    let (scheme, absorbing) = variant(row);
    let others = variants(rows);
    let mut words = vec![row.strategy.clone()];
    if others.iter().any(|other| other.0 != scheme) {
        words.extend(scheme.map(scheme_name));
    }
    if row.discrete.is_some() && others.iter().any(|other| other.1 != absorbing) {
        words.push(format!("{} mean", mean_name(absorbing)));
    }
    words.join(", ")
}

/// Operator applications of a row with a result; none for a homogeneous layer, which needs no
/// iteration.
fn counted(row: &Row) -> f64 {
    if row.converged() && row.applications() > 0 { row.applications() as f64 } else { f64::NAN }
}

fn error(row: &Row) -> f64 {
    row.result.as_ref().map_or(f64::NAN, |&error| if error > 0.0 { error } else { f64::NAN })
}
