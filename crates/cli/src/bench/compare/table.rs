//! A comparison as a table.

use serde_json::Value;

use super::{CLOCKS, Comparison, Pair};
use crate::bench::spread::Spread;
use crate::terminal::print;

/// Prints `comparison` for people, one block per clock that either run has.
pub fn print_table(comparison: &Comparison) {
    print(format_args!("A: {}", comparison.a.display()));
    print(format_args!("B: {}", comparison.b.display()));
    if comparison.differences.is_empty() {
        print("the runs are set up alike");
    } else {
        print("the runs are set up differently; the ratios are not of the program alone:");
        let shown = |value: &Option<Value>| value.as_ref().map_or_else(|| "-".to_owned(), Value::to_string);
        for difference in &comparison.differences {
            let (a, b) = (shown(&difference.a), shown(&difference.b));
            print(format_args!("  {}: {a} in A, {b} in B", difference.key));
        }
    }
    for clock in CLOCKS {
        let of_clock = |pairs: &'_ [Pair]| pairs.iter().position(|pair| pair.clock == clock);
        let rows: Vec<(&str, &Pair)> = std::iter::once(("whole frame", &comparison.whole_frame))
            .chain(comparison.stages.iter().map(|stage| (stage.name.as_str(), &stage.clocks)))
            .filter_map(|(name, pairs)| Some((name, &pairs[of_clock(pairs)?])))
            .collect();
        if rows.is_empty() {
            continue;
        }
        let title = clock.replace("_ms", ", ms");
        print(format_args!(
            "{title:28} {:>26} {:>26} {:>8}",
            "A median (min-max)", "B median (min-max)", "B/A"
        ));
        for (name, pair) in rows {
            print(format_args!(
                "  {name:26} {:>26} {:>26} {:>8}{}",
                cell(pair.a),
                cell(pair.b),
                pair.ratio.map_or_else(|| "-".to_owned(), |ratio| format!("{ratio:.3}")),
                if pair.overlap == Some(true) { "  ranges overlap" } else { "" },
            ));
        }
    }
}

fn cell(spread: Option<Spread>) -> String {
    spread.map_or_else(|| "-".to_owned(), |s| format!("{:.2} ({:.2}-{:.2})", s.median, s.min, s.max))
}
