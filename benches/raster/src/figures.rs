use std::fmt::Write;

use bench_views::Sample;

use crate::{Agreement, Case};

/// What a case takes both ways.
#[derive(Clone, Copy, Debug)]
pub struct Times {
    /// By the compute passes of the surface stage.
    pub compute: Sample,
    /// As triangles.
    pub triangles: Sample,
}

impl Times {
    /// Milliseconds of both: the GPU's own where it has told those of both, else of all threads of the process.
    fn ms(&self) -> ([f64; 2], &'static str) {
        match (self.compute.gpu_ms, self.triangles.gpu_ms) {
            (Some(compute), Some(triangles)) => ([compute, triangles], "GPU"),
            _ => ([self.compute.cpu_ms, self.triangles.cpu_ms], "CPU"),
        }
    }

    fn do_triangles_win(&self) -> bool {
        let ([compute, triangles], _) = self.ms();
        triangles < compute
    }
}

/// A case and what came out.
#[derive(Clone, Debug)]
pub struct Row {
    /// The case.
    pub case: Case,
    /// What it takes; if the pictures differ, how much.
    pub outcome: Result<Times, Agreement>,
}

impl Row {
    fn do_triangles_win(&self) -> bool {
        self.outcome.is_ok_and(|times| times.do_triangles_win())
    }
}

/// A table of `rows`, in Markdown.
pub fn table(rows: &[Row]) -> String {
    let mut table = "| radius | particles | clock | compute, ms | triangles, ms | triangles / compute |\n\
                     |---|---|---|---|---|---|\n"
        .to_owned();
    for Row { case, outcome } in rows {
        let _ = write!(table, "| {} | {} |", case.name, case.particles());
        let _ = match outcome {
            Ok(times) => {
                let ([compute, triangles], clock) = times.ms();
                let ratio = triangles / compute;
                writeln!(table, " {clock} | {compute:.2} | {triangles:.2} | {ratio:.2} |")
            }
            Err(agreement) => {
                writeln!(table, " - | - | - | DIFFERENT PICTURES, {:.1} % |", agreement.differing_percent())
            }
        };
    }
    table
}

/// From which radius on triangles are faster, of `rows` from small to large radii.
pub fn crossover(rows: &[Row]) -> String {
    let equal: Vec<&Row> = rows.iter().filter(|row| row.case.is_equal()).collect();
    let first = equal.iter().rposition(|row| !row.do_triangles_win()).map_or(0, |last_lost| last_lost + 1);
    if let Some(row) = equal.get(first) {
        return format!("crossover: {} px", row.case.radius_px);
    }
    let won: Vec<_> = rows.iter().filter(|row| row.do_triangles_win()).map(|row| &*row.case.name).collect();
    match &won[..] {
        [] => "none: compute is faster at all sizes".into(),
        won => format!("none: compute is faster at the largest size, triangles at {}", won.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(cpu_ms: f64, gpu_ms: Option<f64>) -> Sample {
        Sample { wall_ms: 1.0, cpu_ms, gpu_ms }
    }

    /// Every case, with triangles taking `ratios` times as long by the processor's clock.
    fn rows(ratios: [f64; 10]) -> Vec<Row> {
        let times = |ratio| Times { compute: sample(2.0, None), triangles: sample(2.0 * ratio, None) };
        Case::all().into_iter().zip(ratios).map(|(case, r)| Row { case, outcome: Ok(times(r)) }).collect()
    }

    #[test]
    fn triangles_win_from_the_first_size_after_which_they_never_lose() {
        assert_eq!(crossover(&rows([2.0; 10])), "none: compute is faster at all sizes");
        assert_eq!(crossover(&rows([9.0, 8.0, 0.9, 4.0, 2.0, 0.8, 0.7, 0.5, 3.0, 3.0])), "crossover: 14 px");
        assert_eq!(crossover(&rows([0.5; 10])), "crossover: 0.6 px");
        assert_eq!(
            crossover(&rows([2.0, 2.0, 0.5, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 0.5])),
            "none: compute is faster at the largest size, triangles at 2.5 px, 1 and 300 px"
        );
    }

    #[test]
    fn the_gpus_own_clock_is_preferred() {
        let mut rows = rows([2.0; 10]);
        assert!(table(&rows).contains("| 5 px | 50929 | CPU | 2.00 | 4.00 | 2.00 |"), "{}", table(&rows));
        for row in &mut rows {
            let times = Times { compute: sample(2.0, Some(3.0)), triangles: sample(9.0, Some(1.5)) };
            row.outcome = Ok(times);
        }
        assert!(table(&rows).contains("| 5 px | 50929 | GPU | 3.00 | 1.50 | 0.50 |"), "{}", table(&rows));
        assert_eq!(crossover(&rows), "crossover: 0.6 px");
    }

    #[test]
    fn different_pictures_have_no_times_and_win_nothing() {
        let mut rows = rows([0.5; 10]);
        rows[3].outcome = Err(Agreement { covered: 1000, equal: 750 });
        assert!(
            table(&rows).contains("| 5 px | 50929 | - | - | - | DIFFERENT PICTURES, 25.0 % |"),
            "{}",
            table(&rows)
        );
        assert_eq!(crossover(&rows), "crossover: 10 px");
    }
}
