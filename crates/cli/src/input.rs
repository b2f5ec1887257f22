//! From input flags to an open series.

use std::path::Path;

use meniscus_core::Cancel;
use meniscus_io::{Series, SeriesOptions, SetSpec};

use crate::args::InputArgs;
use crate::failure::Failure;

/// Opens what the flags name, unless `cancel` stops it: surveying a large first frame takes seconds. What is no picture keeps what is
/// no water (`keep_others`).
pub fn open(args: &InputArgs, keep_others: bool, cancel: &Cancel) -> Result<Series, Failure> {
    let sets = args.sets.iter().map(|text| SetSpec::parse(text)).collect::<Result<Vec<_>, _>>()?;
    let options = SeriesOptions {
        where_expr: args.where_expr.clone(),
        sets,
        spacing: args.spacing,
        radius: args.radius,
        radius_by: args.radius_by.clone(),
        up: args.up.axis(),
        metres_per_unit: args.unit.map(|unit| unit.0),
        every: args.every,
        region: args.region,
        time_step: args.time_step,
        keep_others,
        keep_ghosts: args.keep_ghosts,
        io_mode: args.io_mode,
    };
    Ok(Series::open_unless(Path::new(&args.input), &options, cancel)?)
}
