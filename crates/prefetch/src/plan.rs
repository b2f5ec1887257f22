/// Which frames come next. Frames outside the series are skipped.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Plan {
    /// Exactly these, in this order, then nothing.
    Frames(Vec<usize>),
    /// Play from `playhead` on.
    Play {
        /// The next frame shown.
        playhead: usize,
        /// Frames from one shown to the next: 1 forwards, -1 backwards, 4 forwards showing every fourth. 0 is paused: the
        /// frames around the playhead are wanted, nearest first.
        step: isize,
        /// Whether the series starts over at its end.
        looping: bool,
    },
}

impl Plan {
    /// Nothing is wanted.
    pub const IDLE: Self = Self::Frames(Vec::new());

    /// The frames of a series of `count` in the order in which they will be shown, each once.
    pub(crate) fn upcoming(&self, count: usize) -> Vec<usize> {
        let mut seen = vec![false; count];
        let first_time = |&frame: &usize| frame < count && !std::mem::replace(&mut seen[frame], true);
        match *self {
            Self::Frames(ref frames) => frames.iter().copied().filter(first_time).collect(),
            Self::Play { playhead, .. } if playhead >= count => Vec::new(),
            Self::Play { playhead, step: 0, .. } => (0..count)
                .flat_map(|distance| [playhead.checked_add(distance), playhead.checked_sub(distance)])
                .flatten()
                .filter(first_time)
                .collect(),
            Self::Play { playhead, step, looping } => {
                std::iter::successors(Some(playhead), |&frame| following(frame, step, looping, count))
                    .take_while(first_time)
                    .collect()
            }
        }
    }

    /// Notes that `shown` has been shown: what lay before it in the plan is skipped. A frame that the plan does not have
    /// changes nothing, and neither does any frame while paused.
    pub(crate) fn advance_past(&mut self, shown: usize, count: usize) {
        match self {
            Self::Frames(frames) => {
                if let Some(place) = frames.iter().position(|&frame| frame == shown) {
                    frames.drain(..=place);
                }
            }
            Self::Play { step: 0, .. } => {}
            &mut Self::Play { step, looping, .. } => {
                if self.upcoming(count).contains(&shown) {
                    // Behind the end there is nothing yet, but a series may grow.
                    let behind = || shown.checked_add_signed(step);
                    *self = match following(shown, step, looping, count).or_else(behind) {
                        Some(playhead) => Self::Play { playhead, step, looping },
                        None => Self::IDLE,
                    };
                }
            }
        }
    }
}

fn following(frame: usize, step: isize, looping: bool, count: usize) -> Option<usize> {
    if looping {
        let step = step.rem_euclid(count as isize) as usize;
        Some((frame + step) % count)
    } else {
        frame.checked_add_signed(step).filter(|&next| next < count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn play(playhead: usize, step: isize, looping: bool) -> Plan {
        Plan::Play { playhead, step, looping }
    }

    #[test]
    fn upcoming_frames() {
        assert_eq!(play(3, 1, false).upcoming(6), [3, 4, 5]);
        assert_eq!(play(3, -1, false).upcoming(6), [3, 2, 1, 0]);
        assert_eq!(play(3, 1, true).upcoming(6), [3, 4, 5, 0, 1, 2]);
        assert_eq!(play(1, -1, true).upcoming(4), [1, 0, 3, 2]);
        assert_eq!(play(1, 4, true).upcoming(6), [1, 5, 3]);
        assert_eq!(play(2, 0, false).upcoming(5), [2, 3, 1, 4, 0]);
        assert_eq!(play(1, isize::MIN, false).upcoming(3), [1]);
        assert_eq!(play(7, 1, true).upcoming(6), [0; 0]);
        assert_eq!(play(0, 1, true).upcoming(0), [0; 0]);
        assert_eq!(Plan::Frames(vec![4, 2, 9, 4]).upcoming(6), [4, 2]);
    }

    #[test]
    fn showing_a_frame_moves_on() {
        let after = |mut plan: Plan, shown| {
            plan.advance_past(shown, 6);
            plan.upcoming(6)
        };
        assert_eq!(after(play(3, 1, false), 3), [4, 5]);
        assert_eq!(after(play(3, 1, false), 5), [0; 0]);
        assert_eq!(after(play(3, 1, false), 1), [3, 4, 5]);
        assert_eq!(after(play(5, 1, true), 5), [0, 1, 2, 3, 4, 5]);
        assert_eq!(after(play(2, 0, false), 2)[0], 2);
        assert_eq!(after(Plan::Frames(vec![5, 1, 3]), 1), [3]);
        let mut ended = play(4, 1, false);
        ended.advance_past(5, 6);
        assert_eq!((ended.upcoming(6), ended.upcoming(8)), (vec![], vec![6, 7]), "frames were added");
    }
}
