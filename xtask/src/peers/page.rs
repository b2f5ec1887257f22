//! Pictures and tables on one page, beside the pictures' files.

use super::{
    fluid::{self, Comparison, Variant},
    readers::{self, Readings},
    samples::spread,
};

const STYLE: &str = "
:root { color-scheme: light dark; }
body { font: 15px/1.5 system-ui, sans-serif; max-width: 1800px; margin: 2em auto; padding: 0 1.5em; }
h2 { margin-top: 2.5em; }
figure { margin: 0; flex: 0 1 calc(50% - .5em); min-width: 480px; }
figure img { width: 100%; display: block; border-radius: 4px; }
figcaption { padding: .3em 0 1em; }
.row { display: flex; flex-wrap: wrap; gap: 1em; }
table { border-collapse: collapse; margin: 1em 0; font-variant-numeric: tabular-nums; }
td, th { padding: .25em .9em; border-bottom: 1px solid #8886; text-align: right; }
td:first-child, th:first-child { text-align: left; }
.meta { color: #888; }
";

/// The page; `machine` and `vtk` say on what.
pub fn html(machine: &str, vtk: &str, views: &[Vec<Comparison>], files: &[Readings]) -> String {
    let mut body = format!(
        "<h1>meniscus beside VTK {}</h1><p class=meta>{}<br>{}</p>",
        escaped(vtk),
        escaped(machine),
        "The same file, camera, radius and size, taken in turn in one run; made by <code>cargo xtask peers</code>."
    );
    for comparison in views.iter().flatten() {
        let files = &comparison.files;
        body += &format!(
            "<h2>{} <small>radius {:.3} spacings</small></h2><p>{} particles, {}x{}: {}.</p>",
            escaped(&files.view),
            comparison.radius_spacings,
            files.particles,
            files.size[0],
            files.size[1],
            escaped(&files.why),
        );
        body += "<div class=row>";
        body.extend(comparison.theirs.iter().chain(&comparison.ours).map(figure));
        body += "</div>";
    }
    body += "<h2>What a frame costs</h2>";
    body += &tables(&fluid::markdown(views));
    if !files.is_empty() {
        body += "<h2>Readers</h2>";
        body += &tables(&readers::markdown(files));
    }
    format!(
        "<!doctype html><html lang=en><meta charset=utf-8><title>meniscus beside VTK</title><style>{STYLE}</style>{body}</html>"
    )
}

/// A picture with what it cost; nothing for a tool that is not there.
fn figure(variant: &Variant) -> String {
    let Some(samples) = &variant.samples else { return String::new() };
    let parent = variant.picture.parent().and_then(|folder| folder.file_name()).unwrap_or_default();
    let name = variant.picture.file_name().unwrap_or_default();
    let source = format!("{}/{}", parent.to_string_lossy(), name.to_string_lossy());
    format!(
        "<figure><a href=\"{0}\"><img src=\"{0}\" alt=\"{1}\"></a><figcaption><b>{1}</b>: {2} CPU-ms</figcaption></figure>",
        escaped(&source),
        escaped(variant.name),
        spread(&samples.cpu_ms),
    )
}

/// Our own markdown: tables, and lines between them.
fn tables(markdown: &str) -> String {
    let mut html = String::new();
    let mut in_table = false;
    for line in markdown.lines() {
        let is_row = line.starts_with('|');
        if is_row != in_table {
            html += if is_row { "<table>" } else { "</table>" };
            in_table = is_row;
        }
        if line.starts_with("|---") {
            continue;
        }
        if is_row {
            let cells =
                line.trim_matches('|').split('|').map(|cell| format!("<td>{}</td>", inline(cell.trim())));
            html += &format!("<tr>{}</tr>", cells.collect::<String>());
        } else if !line.is_empty() {
            html += &format!("<p>{}</p>", inline(line));
        }
    }
    html + if in_table { "</table>" } else { "" }
}

/// Escaped, with `**bold**`.
fn inline(text: &str) -> String {
    let mut html = String::new();
    for (i, part) in text.split("**").enumerate() {
        html += &if i % 2 == 1 { format!("<b>{}</b>", escaped(part)) } else { escaped(part) };
    }
    html
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_keep_their_cells_and_nothing_gets_out_of_them() {
        let html = tables("**a < b**\n\n| x | 1 |\n|---|---|\n| **y** | 2 |\n\nend\n");
        assert_eq!(
            html,
            "<p><b>a &lt; b</b></p><table><tr><td>x</td><td>1</td></tr><tr><td><b>y</b></td><td>2</td></tr></table><p>end</p>"
        );
    }
}
