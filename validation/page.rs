//! The report's files: a self-contained page, the same in Markdown, all numbers as JSON and CSV.

use crate::Judged;
use crate::changes::{Changes, changes};
use crate::claim::{Check, Table, short};
use crate::history::{Night, Trend, margins, trend};
use crate::manifest::Manifest;
use inkwave::draw::chart::Chart;
use inkwave::draw::seal::sealed_by;
use inkwave::store::safely;
use minijinja::syntax::SyntaxConfig;
use minijinja::{Environment, value::Serde};
use serde::Serialize;
use std::error::Error;
use std::path::Path;

/// The claim whose first table is README's accuracy.
const ACCURACY: &str = "08-references";

/// One line of the verdict table, and the claim's chapter.
#[derive(Serialize)]
struct Chapter {
    id: &'static str,
    file: &'static str,
    statement: &'static str,
    because: &'static str,
    holds: bool,
    failure: Option<String>,
    what: String,
    measured: String,
    bound: String,
    margin: String,
    trend: String,
    shrinking: bool,
    spark: Option<String>,
    seconds: String,
    checks: Vec<Line>,
    plots: Vec<String>,
    tables: Vec<Table>,
}

/// What the templates see.
#[derive(Serialize)]
struct Report<'a> {
    manifest: &'a Manifest,
    changes: Changes,
    chapters: Vec<Chapter>,
}

#[derive(Serialize)]
struct Line {
    what: String,
    measured: String,
    bound: String,
    margin: String,
    holds: bool,
    reason: String,
    because: String,
}

fn line(check: &Check) -> Line {
    Line {
        what: check.what.clone(),
        measured: short(check.measured),
        bound: check.bound.to_string(),
        margin: margin(check.margin()),
        holds: check.holds(),
        reason: check.reason.to_string(),
        because: check.because.clone(),
    }
}

fn margin(value: f64) -> String {
    if value >= 1e6 { "> 1e6".into() } else { short(value) }
}

/// The plot, or why it cannot be drawn: one empty plot must not cost the report.
fn drawn(plot: &Chart) -> String {
    plot.svg().unwrap_or_else(|reason| format!("<p>{}</p>", reason.to_string().replace('<', "&lt;")))
}

fn chapter(judged: &Judged, nights: &[Night]) -> Chapter {
    let claim = judged.claim;
    let measured = &judged.measured;
    let tightest = measured.findings.tightest().map(line);
    let text = |pick: fn(&Line) -> &String| tightest.as_ref().map_or_else(|| "–".into(), |l| pick(l).clone());
    let mut all = margins(nights, claim.id);
    let trend = trend(&all, measured.margin());
    all.push(measured.margin());
    Chapter {
        id: claim.id,
        file: claim.file,
        statement: claim.statement,
        because: claim.because,
        holds: measured.holds(),
        failure: measured.failure.clone(),
        what: text(|l| &l.what),
        measured: text(|l| &l.measured),
        bound: text(|l| &l.bound),
        margin: text(|l| &l.margin),
        trend: match trend {
            Trend::First => "first night".into(),
            Trend::Steady(r) => format!("steady (×{r:.2})"),
            Trend::Shrinking(r) => format!("shrinking (×{r:.2})"),
            Trend::Growing(r) => format!("growing (×{r:.2})"),
        },
        shrinking: matches!(trend, Trend::Shrinking(_)),
        spark: spark(&all),
        seconds: short(measured.seconds),
        checks: measured.findings.checks.iter().map(line).collect(),
        plots: measured.findings.plots.iter().map(drawn).collect(),
        tables: measured.findings.tables.clone(),
    }
}

/// Points of a polyline 80 × 18: margins of the last nights on a logarithmic scale from 0.5 to 1000.
fn spark(margins: &[f64]) -> Option<String> {
    const SHOWN: usize = 30;
    let last = &margins[margins.len().saturating_sub(SHOWN)..];
    let height = |m: f64| 17.0 - 16.0 * (m.clamp(0.5, 1000.0).ln() - 0.5f64.ln()) / (2000f64).ln();
    let step = 78.0 / (last.len().max(2) - 1) as f64;
    let point = |(i, m): (usize, &f64)| format!("{:.1},{:.1}", 1.0 + step * i as f64, height(*m));
    (last.len() > 1).then(|| last.iter().enumerate().map(point).collect::<Vec<_>>().join(" "))
}

/// Writes index.html, report.md, numbers.json and checks.csv into `folder`.
pub fn write(
    folder: &Path,
    manifest: &Manifest,
    judged: &[Judged],
    nights: &[Night],
) -> Result<(), Box<dyn Error>> {
    std::fs::create_dir_all(folder)?;
    let chapters: Vec<Chapter> = judged.iter().map(|j| chapter(j, nights)).collect();
    let report = Report { manifest, changes: changes(judged, nights), chapters };
    let mut templates = Environment::new();
    templates.set_syntax(SyntaxConfig::builder().trim_blocks(true).lstrip_blocks(true).build()?);
    templates.add_template("style.css", inkwave::draw::page::STYLE)?;
    templates.add_template("index.html", include_str!("page.html"))?;
    templates.add_template("report.md", include_str!("page.md"))?;
    for name in ["index.html", "report.md"] {
        let text = templates.get_template(name)?.render(Serde(&report))?;
        let text = if name.ends_with(".md") { sealed_by(&text, manifest.method) } else { text };
        safely::write(&folder.join(name), text.as_bytes())?;
    }
    let measured: Vec<_> = judged.iter().map(|j| &j.measured).collect();
    let numbers = serde_json::to_vec(&serde_json::json!({ "manifest": manifest, "claims": measured }))?;
    safely::write(&folder.join("numbers.json"), &numbers)?;
    Ok(safely::write(&folder.join("checks.csv"), &checks(judged)?)?)
}

fn checks(judged: &[Judged]) -> csv::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(["claim", "what", "measured", "bound", "margin", "holds", "reason", "because"])?;
    for j in judged {
        for c in &j.measured.findings.checks {
            let [measured, margin] = [c.measured, c.margin()].map(|v| format!("{v:e}"));
            let bound = c.bound.to_string();
            let holds = c.holds().to_string();
            let reason = c.reason.to_string();
            writer.write_record([
                j.claim.id, &c.what, &measured, &bound, &margin, &holds, &reason, &c.because,
            ])?;
        }
    }
    writer.into_inner().map_err(|e| e.into_error().into())
}

/// Replaces what stands between `<!-- name -->` and `<!-- /name -->` for the verdict table and the table of accuracies.
pub fn splice(path: &Path, judged: &[Judged]) -> Result<(), Box<dyn Error>> {
    let mut text = std::fs::read_to_string(path)?;
    let verdicts = judged.iter().map(|j| {
        let l = j.measured.findings.tightest().map(line);
        let cell = |pick: fn(&Line) -> &String| l.as_ref().map_or("–", |l| pick(l)).to_string();
        let verdict = if j.measured.holds() { "holds" } else { "**fails**" };
        // The page lies in reports/latest.
        let link = format!("[{}](../../{})", j.claim.id, j.claim.file);
        vec![
            link,
            verdict.into(),
            cell(|l| &l.what),
            cell(|l| &l.measured),
            cell(|l| &l.bound),
            cell(|l| &l.margin),
        ]
    });
    let columns =
        ["claim", "verdict", "tightest number", "measured", "bound", "margin"].map(String::from).to_vec();
    let verdicts = Table { title: String::new(), columns, rows: verdicts.collect() };
    let references = judged.iter().find(|j| j.claim.id == ACCURACY);
    let accuracy = references.and_then(|j| j.measured.findings.tables.first());
    for (name, table) in [("verdicts", Some(&verdicts)), ("accuracy", accuracy)] {
        let open = format!("<!-- {name} -->\n");
        let close = format!("<!-- /{name} -->");
        let place = text.find(&open).zip(text.find(&close)).zip(table);
        let ((start, end), table) =
            place.ok_or_else(|| format!("{} has no place for {name}", path.display()))?;
        text.replace_range(start + open.len()..end, &markdown(table));
    }
    Ok(safely::write(path, text.as_bytes())?)
}

fn markdown(table: &Table) -> String {
    let cell = |cell: &String| cell.replace('|', "\\|");
    let row =
        |cells: &Vec<String>| format!("| {} |\n", cells.iter().map(cell).collect::<Vec<_>>().join(" | "));
    let rule = format!("|{}\n", "---|".repeat(table.columns.len()));
    row(&table.columns) + &rule + &table.rows.iter().map(row).collect::<String>()
}
