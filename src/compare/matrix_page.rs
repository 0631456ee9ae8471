//! The matrix on paper: a table of costs, the reasons of those that failed, and plots against the cell.

use super::error::missing;
use super::matrix::{Cell, Matrix};
use super::pages::{ComparisonError, place_in};
use crate::draw::chart::{Chart, Curve, Style};
use crate::report::page::{STYLE, svg_data};
use crate::report::seal::sealed;
use minijinja::{Environment, context};
use std::path::Path;

impl Matrix {
    /// Writes `matrix.csv`, `matrix.html`, `README.md` and the plots into `folder`, each whole or not at all.
    ///
    /// # Errors
    /// A folder that cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), ComparisonError> {
        let failed =
            |path: &Path, source| ComparisonError::Write { path: path.display().to_string(), source };
        std::fs::create_dir_all(folder).map_err(|e| failed(folder, e))?;
        let save = |name: &str, bytes: &[u8]| {
            let path = folder.join(name);
            crate::store::safely::write(&path, bytes).map_err(|e| failed(&path, e))
        };
        save("matrix.csv", &self.csv()?)?;
        let mut pictures = Vec::new();
        for (name, plot) in self.plots() {
            let svg = plot.svg()?;
            save(&name, svg.as_bytes())?;
            pictures.push((name, plot.title, svg));
        }
        save("README.md", sealed(&self.markdown(&pictures, &self.command(folder))).as_bytes())?;
        save("matrix.html", self.html(&pictures, &self.command(folder))?.as_bytes())
    }

    fn csv(&self) -> Result<Vec<u8>, csv::Error> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        self.cells.iter().try_for_each(|cell| writer.serialize(cell))?;
        Ok(writer.into_inner().unwrap_or_default())
    }

    /// The cases in their order: the first cell of each.
    fn cases(&self) -> impl Iterator<Item = &[Cell]> {
        self.cells.chunks(self.strategies.len().max(1))
    }

    fn header(&self) -> Vec<String> {
        let fixed = ["pigment n + iκ", "period, µm", "grid", "grid error"].map(String::from);
        fixed.into_iter().chain(self.strategies.iter().cloned()).collect()
    }

    fn rows(&self) -> Vec<Vec<String>> {
        self.cases().map(|case| [fixed(&case[0]), case.iter().map(cost).collect()].concat()).collect()
    }

    /// Who failed, where, and why: one line a failure.
    fn failures(&self) -> Vec<[String; 3]> {
        let failed = self.cells.iter().filter(|cell| !cell.converged());
        failed.map(|c| [c.strategy.clone(), place(c), c.outcome.replace('\n', " ")]).collect()
    }

    /// Applications against the period, one plot a pigment; lines are broken where a strategy fails.
    fn plots(&self) -> Vec<(String, Chart)> {
        let mut pigments: Vec<[f64; 2]> = self.cells.iter().map(|c| [c.n, c.kappa]).collect();
        pigments.dedup();
        pigments.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
        pigments.dedup();
        let plots = pigments.into_iter().enumerate().map(|(k, pigment)| (k, self.plot(pigment)));
        let shown = plots.filter(|(_, plot)| !plot.curves.is_empty());
        shown.map(|(k, plot)| (format!("applications-{}.svg", k + 1), plot)).collect()
    }

    /// Operator applications of every strategy on a pigment against the period.
    fn plot(&self, pigment: [f64; 2]) -> Chart {
        let curves = self.strategies.iter().map(|name| self.curve(pigment, name));
        let curves = curves.filter(|c| c.points.iter().any(|p| p[1].is_finite())).collect();
        let title = format!("Pigment {} + {}i", pigment[0], pigment[1]);
        Chart::log_log(&title, "period, µm", "operator applications", curves)
    }

    /// Operator applications of one strategy; its colour and marker are the same in every plot.
    fn curve(&self, pigment: [f64; 2], strategy: &str) -> Curve {
        let own = self.cells.iter().filter(|c| [c.n, c.kappa] == pigment && c.strategy == strategy);
        let there = |c: &Cell| c.converged() && c.operator_applications > 0;
        let cost = |c: &Cell| if there(c) { c.operator_applications as f64 } else { f64::NAN };
        let costs = own.map(|c| (c.period_um, cost(c)));
        let place = place_in(&self.registry, strategy);
        Curve::new(strategy.to_owned(), Style::Data, costs).looking(place, place)
    }

    fn markdown(&self, pictures: &[(String, String, String)], command: &str) -> String {
        let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
        let mut text = format!("# {}\n\n{}\n\nMade by `{command}`.\n\n", self.title, self.lead());
        text += &line(&self.header());
        text += &format!("|{}\n", "---|".repeat(self.header().len()));
        self.rows().iter().for_each(|row| text += &line(row));
        text += "\n## Who fails where, and why\n\n| strategy | case | reason |\n|---|---|---|\n";
        self.failures().iter().for_each(|row| text += &line(row));
        text += "\n";
        pictures.iter().for_each(|(name, title, _)| text += &format!("![{title}]({name})\n"));
        text
    }

    fn html(&self, pictures: &[(String, String, String)], command: &str) -> Result<String, minijinja::Error> {
        let mut templates = Environment::new();
        templates.add_template("style.css", STYLE)?;
        templates.add_template("matrix.html", include_str!("matrix.html"))?;
        let figures = pictures.iter().map(|(_, title, svg)| context!(title, data => svg_data(svg)));
        templates.get_template("matrix.html")?.render(context! {
            title => &self.title,
            lead => self.lead(),
            command,
            header => self.header(),
            rows => self.rows(),
            failures => self.failures(),
            figures => figures.collect::<Vec<_>>(),
        })
    }

    fn lead(&self) -> String {
        let missing =
            missing(self.cells.len(), self.asked).map_or_else(String::new, |said| format!("{said} "));
        format!(
            "{missing}Cost to a wanted amplitude error of {:.0e}: operator applications (seconds of one solve) on the grid that \
             the search chose; the residual goes to a hundredth of the error. One application is one inverse and one \
             forward transform of every plane. A strategy that is not there after {} applications fails; it looks at its residual \
             every few steps, so failures, which say after how many applications, may be some beyond.",
            self.accuracy, self.max_applications
        )
    }

    /// What makes this page again.
    fn command(&self, folder: &Path) -> String {
        format!("inkwave compare {} --output {}", self.file.display(), folder.display())
    }
}

fn fixed(cell: &Cell) -> Vec<String> {
    vec![
        format!("{} + {}i", cell.n, cell.kappa),
        cell.period_um.to_string(),
        format!("{0} × {0} × {1}", cell.points, cell.cells),
        format!("{:.1e}", cell.error_estimate),
    ]
}

fn cost(cell: &Cell) -> String {
    if cell.converged() {
        return format!("{} ({:.3} s)", cell.operator_applications, cell.seconds);
    }
    format!("fails ({})", cell.operator_applications)
}

fn place(cell: &Cell) -> String {
    format!("{} + {}i, {} µm", cell.n, cell.kappa, cell.period_um)
}
