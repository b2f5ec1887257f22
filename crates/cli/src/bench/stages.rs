//! The clocks of stages over many frames.

use std::collections::BTreeMap;

use meniscus_core::StageCost;

use super::spread::Spread;

/// Clocks of every stage over all frames, in the order in which stages first ran.
#[derive(Default)]
pub struct StageSamples {
    order: Vec<String>,
    samples: BTreeMap<String, [Vec<f64>; 3]>,
}

impl StageSamples {
    pub fn add(&mut self, costs: Vec<StageCost>) {
        for cost in costs {
            if !self.samples.contains_key(&cost.name) {
                self.order.push(cost.name.clone());
            }
            let clocks = self.samples.entry(cost.name).or_default();
            for (clock, value) in clocks.iter_mut().zip([cost.gpu_ms, cost.wall_ms, cost.cpu_ms]) {
                clock.extend(value);
            }
        }
    }

    /// GPU, wall and CPU milliseconds of every stage; `None` for a clock without samples.
    pub fn spreads(&self) -> impl Iterator<Item = (&str, [Option<Spread>; 3])> {
        self.order.iter().map(|name| {
            let clocks = &self.samples[name];
            (name.as_str(), [0, 1, 2].map(|clock| Spread::of(&clocks[clock])))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_keep_their_order_and_a_missing_clock_stays_missing() {
        let cost = |name: &str, gpu_ms| StageCost { name: name.into(), gpu_ms, ..Default::default() };
        let mut samples = StageSamples::default();
        samples.add(vec![cost("b", Some(1.0)), cost("a", None)]);
        samples.add(vec![cost("b", Some(3.0)), cost("a", None)]);
        let spreads: Vec<_> = samples.spreads().collect();
        let gpu = Some(Spread { median: 2.0, min: 1.0, max: 3.0 });
        assert_eq!(spreads, [("b", [gpu, None, None]), ("a", [None; 3])]);
    }
}
