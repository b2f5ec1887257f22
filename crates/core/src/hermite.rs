/// Weights of a cubic Hermite curve at `share` of the way, 0..=1, for: the value at the start, the slope there, the value at the end,
/// the slope there; slopes are per whole way. Exact for cubic curves.
pub fn hermite_weights(share: f64) -> [f64; 4] {
    let (s, s2, s3) = (share, share * share, share * share * share);
    [2.0 * s3 - 3.0 * s2 + 1.0, s3 - 2.0 * s2 + s, 3.0 * s2 - 2.0 * s3, s3 - s2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubics_are_reproduced() {
        let value = |t: f64| 2.0 - t + 0.5 * t * t + 3.0 * t * t * t;
        let slope = |t: f64| -1.0 + t + 9.0 * t * t;
        let (from, to) = (0.5, 2.0);
        for share in [0.0, 0.1, 0.5, 0.9, 1.0] {
            let known = [value(from), slope(from) * (to - from), value(to), slope(to) * (to - from)];
            let sum: f64 = hermite_weights(share).iter().zip(known).map(|(w, v)| w * v).sum();
            // 1e-12: rounding of sums of size 30.
            assert!((sum - value(from + share * (to - from))).abs() < 1e-12, "{share}");
        }
    }
}
