use glam::{DVec3, Vec3};

/// Axis-aligned box in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Smallest corner.
    pub min: Vec3,
    /// Largest corner.
    pub max: Vec3,
}

impl Aabb {
    /// The box that holds nothing; growing it by a point gives that point.
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// Smallest box around `points`; [`Self::EMPTY`] for none. NaN coordinates are ignored.
    pub fn of_points<'a>(points: impl IntoIterator<Item = &'a [f32; 3]>) -> Self {
        points.into_iter().fold(Self::EMPTY, |bounds, &p| bounds.with_point(p.into()))
    }

    /// This box grown to hold `point`.
    #[must_use]
    pub fn with_point(self, point: Vec3) -> Self {
        Self { min: self.min.min(point), max: self.max.max(point) }
    }

    /// Smallest box that holds both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// This box grown by `margin` (world units) on all sides.
    #[must_use]
    pub fn inflated(self, margin: f32) -> Self {
        Self { min: self.min - margin, max: self.max + margin }
    }

    /// Whether `point` lies inside or on a side; never for NaN.
    pub fn contains(&self, point: Vec3) -> bool {
        self.min.cmple(point).all() && point.cmple(self.max).all()
    }

    /// Whether no point lies inside.
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// Centre; meaningless for an empty box.
    pub fn center(&self) -> Vec3 {
        (self.min + self.max) * 0.5
    }

    /// Edge lengths; zero for an empty box.
    pub fn extent(&self) -> Vec3 {
        if self.is_empty() { Vec3::ZERO } else { self.max - self.min }
    }

    /// The eight corners, x fastest.
    pub fn corners(&self) -> [Vec3; 8] {
        std::array::from_fn(|i| {
            let pick =
                |bit: usize, axis: usize| if i >> bit & 1 == 1 { self.max[axis] } else { self.min[axis] };
            Vec3::new(pick(0, 0), pick(1, 1), pick(2, 2))
        })
    }

    /// The same box in the file's coordinates as `[xmin, xmax, ymin, ymax, zmin, zmax]`.
    pub fn in_file(&self, origin: DVec3) -> [f64; 6] {
        let (lo, hi) = (self.min.as_dvec3() + origin, self.max.as_dvec3() + origin);
        [lo.x, hi.x, lo.y, hi.y, lo.z, hi.z]
    }
}
