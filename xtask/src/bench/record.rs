//! The records that benches leave (`benches/views/src/record.rs`) and what is computed from them.

use serde::{Deserialize, Serialize};

/// One bench of one run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Record {
    pub stage: String,
    pub bench: String,
    pub view: String,
    /// Adapter and driver, or `CPU`.
    pub device: String,
    /// Bytes that the work has to read and write at least.
    pub bytes: Option<u64>,
    /// Bytes read and written per second by a copy on the same device, 1e9.
    pub copy_gb_per_s: f64,
    pub samples: Vec<Sample>,
}

/// One measurement, milliseconds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    pub wall_ms: f64,
    pub cpu_ms: f64,
    pub gpu_ms: Option<f64>,
}

/// The middle half of some samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    pub low: f64,
    pub median: f64,
    pub high: f64,
}

impl Spread {
    /// `None` without samples.
    fn of(mut values: Vec<f64>) -> Option<Self> {
        values.sort_by(f64::total_cmp);
        let last = values.len().checked_sub(1)?;
        let quantile = |q: f64| {
            let at = q * last as f64;
            let below = values[at.floor() as usize];
            below + at.fract() * (values[at.ceil() as usize] - below)
        };
        Some(Self { low: quantile(0.25), median: quantile(0.5), high: quantile(0.75) })
    }

    /// This over `old`; the spread is as wide as both together allow.
    pub fn over(self, old: Self) -> Self {
        Self { low: self.low / old.high, median: self.median / old.median, high: self.high / old.low }
    }
}

impl Record {
    /// Reads one line each.
    ///
    /// # Errors
    /// The number of the line, from 1, and what is wrong with it.
    pub fn read_all(text: &str) -> Result<Vec<Self>, (usize, serde_json::Error)> {
        let lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
        lines.map(|(i, line)| serde_json::from_str(line).map_err(|error| (i + 1, error))).collect()
    }

    /// What makes two records comparable, but for the device.
    pub fn is_same_bench(&self, other: &Self) -> bool {
        (&self.stage, &self.bench, &self.view) == (&other.stage, &other.bench, &other.view)
    }

    pub fn wall(&self) -> Option<Spread> {
        Spread::of(self.samples.iter().map(|sample| sample.wall_ms).collect())
    }

    pub fn cpu(&self) -> Option<Spread> {
        Spread::of(self.samples.iter().map(|sample| sample.cpu_ms).collect())
    }

    /// `None` unless every sample has its time stamps.
    pub fn gpu(&self) -> Option<Spread> {
        Spread::of(self.samples.iter().map(|sample| sample.gpu_ms).collect::<Option<_>>()?)
    }

    /// Bytes per second, 1e9: by time stamps where there are any, else by the wall.
    pub fn gb_per_s(&self) -> Option<f64> {
        let time = self.gpu().or_else(|| self.wall())?;
        Some(self.bytes? as f64 / time.median * 1e-6).filter(|rate| rate.is_finite())
    }

    /// Share of the copy bandwidth, per cent.
    pub fn copy_percent(&self) -> Option<f64> {
        Some(100.0 * self.gb_per_s()? / self.copy_gb_per_s)
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;

    pub fn record(wall_ms: &[f64]) -> Record {
        let sample = |&wall_ms: &f64| Sample { wall_ms, cpu_ms: 2.0 * wall_ms, gpu_ms: None };
        Record {
            stage: "lod".into(),
            bench: "build".into(),
            view: "dam-break".into(),
            device: "CPU".into(),
            bytes: Some(4_000_000),
            copy_gb_per_s: 8.0,
            samples: wall_ms.iter().map(sample).collect(),
        }
    }

    #[test]
    fn quartiles_are_interpolated() {
        let spread = Spread::of(vec![4.0, 1.0, 2.0, 3.0]).unwrap();
        assert_eq!(spread, Spread { low: 1.75, median: 2.5, high: 3.25 });
        assert_eq!(Spread::of(vec![7.0]).unwrap(), Spread { low: 7.0, median: 7.0, high: 7.0 });
        assert_eq!(Spread::of(vec![]), None);
    }

    #[test]
    fn ratios_are_new_over_old_and_as_wide_as_both() {
        let (new, old) =
            (Spread { low: 1.0, median: 2.0, high: 4.0 }, Spread { low: 2.0, median: 4.0, high: 8.0 });
        assert_eq!(new.over(old), Spread { low: 0.125, median: 0.5, high: 2.0 });
    }

    #[test]
    fn bandwidth_is_bytes_by_time_and_by_the_gpus_own_where_it_is_known() {
        let mut record = record(&[2.0]);
        // 4 MB in 2 ms.
        assert_eq!((record.gb_per_s(), record.copy_percent()), (Some(2.0), Some(25.0)));
        record.samples[0].gpu_ms = Some(1.0);
        assert_eq!((record.gb_per_s(), record.copy_percent()), (Some(4.0), Some(50.0)));
        record.samples.push(Sample { gpu_ms: None, ..record.samples[0] });
        assert_eq!(record.gpu(), None, "half of the stamps are no measurement");
        record.bytes = None;
        assert_eq!(record.copy_percent(), None);
    }

    #[test]
    fn lines_are_read_and_a_broken_one_is_named() {
        let line = r#"{"stage":"io","bench":"read","view":"300k","device":"CPU","bytes":null,"copy_gb_per_s":9.5,"samples":[{"wall_ms":1.5,"cpu_ms":2.5,"gpu_ms":null}]}"#;
        let records = Record::read_all(&format!("{line}\n\n{line}\n")).unwrap();
        assert_eq!(records.len(), 2);
        assert!(records[0].is_same_bench(&records[1]) && records[0].bytes.is_none());
        assert_eq!(Record::read_all(&format!("{line}\n{{}}")).unwrap_err().0, 2);
    }
}
