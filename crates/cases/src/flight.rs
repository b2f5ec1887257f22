use glam::{DVec2, DVec3};

/// Standard gravity, m/s^2.
pub(crate) const GRAVITY: f64 = 9.81;

/// The flight of a droplet: out of its place in the fluid at `launch`, and back into it when it falls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Flight {
    /// Time it leaves, s.
    pub launch: f64,
    /// Speed upwards at launch, m/s.
    pub rise: f64,
    /// Horizontal velocity at launch, m/s, relative to the fluid it left.
    pub drift: DVec2,
}

impl Flight {
    /// Displacement from the droplet's place in the fluid, m; `None` while it is in the fluid.
    pub(crate) fn offset(&self, time: f64) -> Option<DVec3> {
        let duration = 2.0 * self.rise / GRAVITY;
        let since = time - self.launch;
        if since <= 0.0 || since >= duration {
            return None;
        }
        // The drift turns back, so that the droplet lands where its place in the fluid is by then.
        let out = duration / std::f64::consts::PI * (std::f64::consts::PI * since / duration).sin();
        Some((self.drift * out).extend(self.rise * since - 0.5 * GRAVITY * since * since))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_droplet_leaves_and_returns_without_a_jump() {
        let flight = Flight { launch: 1.0, rise: 2.0, drift: DVec2::new(0.5, 0.0) };
        let landing = 1.0 + 4.0 / GRAVITY;
        assert_eq!(flight.offset(0.99), None);
        assert_eq!(flight.offset(landing + 1e-6), None);
        // 1e-6 s at no more than 2.1 m/s.
        assert!(flight.offset(1.0 + 1e-6).is_some_and(|offset| offset.length() < 2.1e-6));
        assert!(flight.offset(landing - 1e-6).is_some_and(|offset| offset.length() < 2.1e-6));
        let top = flight.offset(1.0 + 2.0 / GRAVITY).map_or(0.0, |offset| offset.z);
        assert!((top - 4.0 / (2.0 * GRAVITY)).abs() < 1e-12);
    }
}
