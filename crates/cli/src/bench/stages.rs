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

    pub fn medians(&self) -> Vec<StageCost> {
        let median = |samples: &[f64]| Spread::of(samples).map(|s| s.median);
        self.order
            .iter()
            .map(|name| {
                let [gpu, wall, cpu] = &self.samples[name];
                StageCost {
                    name: name.clone(),
                    gpu_ms: median(gpu),
                    wall_ms: median(wall),
                    cpu_ms: median(cpu),
                }
            })
            .collect()
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
        let medians = samples.medians();
        assert_eq!(medians[0], cost("b", Some(2.0)));
        assert_eq!(medians[1], cost("a", None));
    }
}
