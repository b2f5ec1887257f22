//! What is written over the pictures of a run.

use meniscus_color::ColorScale;
use meniscus_core::{Camera, Projection};
use meniscus_overlay::{Overlay, ScaleBar, decimals_of_step};
use meniscus_pipeline::World;
use meniscus_timeline::Moment;

use super::shots::Shots;
use crate::args::{OverlayItem, RenderArgs};
use crate::failure::Failure;

/// A scale bar takes up at most this share of a picture's width.
const MOST_WIDTH: f64 = 0.25;

/// What is the same for all pictures.
pub struct Captions {
    text: Option<String>,
    /// Digits of the time after the point, if it is shown.
    time: Option<usize>,
    legend: Option<ColorScale>,
    scale: bool,
    metres_per_unit: Option<f64>,
}

impl Captions {
    /// What `args` ask for.
    pub fn plan(args: &RenderArgs, world: &World, shots: &Shots) -> Result<Self, Failure> {
        let has = |item| args.overlay.contains(&item);
        let usage = |message: &str| Err(Failure::Usage(message.to_owned()));
        if has(OverlayItem::Legend) && world.color().is_none() {
            return usage("--overlay legend: nothing is coloured; add --color-by NAME");
        }
        if has(OverlayItem::Text) && args.text.is_none() {
            return usage("--overlay text: there is no text; add --text \"...\"");
        }
        Ok(Self {
            text: args.text.clone(),
            // A single picture shows its time as it is.
            time: has(OverlayItem::Time).then(|| shots.least_step.map_or(4, decimals_of_step)),
            legend: world.color().filter(|_| has(OverlayItem::Legend)).cloned(),
            scale: has(OverlayItem::Scale),
            metres_per_unit: args.input.unit.as_ref().map(|unit| unit.0),
        })
    }

    /// Over the picture of `moment`, `size` pixels large.
    pub fn of(&self, moment: &Moment, camera: &Camera, size: [u32; 2]) -> Overlay {
        let time = self.time.map(|decimals| match moment.time {
            Some(time) => format!("t = {time:.decimals$} s"),
            None => format!("frame {}", moment.number),
        });
        let scale = self.scale.then(|| self.scale_bar(camera, size)).flatten();
        Overlay { text: self.text.clone(), time, legend: self.legend.clone(), scale }
    }

    fn scale_bar(&self, camera: &Camera, [width, height]: [u32; 2]) -> Option<ScaleBar> {
        let (height_units, place) = match camera.projection {
            Projection::Orthographic { height_world } => (f64::from(height_world), ""),
            Projection::Perspective { fovy_rad } => {
                let distance = f64::from(camera.eye.distance(camera.target));
                // Nearer things are longer, farther ones shorter.
                (2.0 * distance * (0.5 * f64::from(fovy_rad)).tan(), "at the centre")
            }
        };
        let px_per_unit = f64::from(height) / height_units;
        ScaleBar::fit(px_per_unit, MOST_WIDTH * f64::from(width), self.metres_per_unit, place)
    }
}
