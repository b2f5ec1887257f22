//! From input flags to an open series.

use std::path::Path;

use meniscus_io::{Series, SeriesOptions, SetSpec};

use crate::args::InputArgs;
use crate::failure::Failure;

/// Opens what the flags name.
pub fn open(args: &InputArgs) -> Result<Series, Failure> {
    let sets = args.sets.iter().map(|text| SetSpec::parse(text)).collect::<Result<Vec<_>, _>>()?;
    let options = SeriesOptions {
        where_expr: args.where_expr.clone(),
        sets,
        spacing: args.spacing,
        radius: args.radius,
        up: args.up.axis(),
        metres_per_unit: args.unit.map(|unit| unit.0),
        ..SeriesOptions::default()
    };
    Ok(Series::open(Path::new(&args.input), &options)?)
}
