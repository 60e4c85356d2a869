//! The stage between two containers: everything that follows the order of patches is reordered.

use radfile::{
    Builder, Container, FLAG_PATCH_ORDER, FLAG_REQUIRED, FormFactors, HierarchicalOperator, Operator, PackedOperator,
    Patches, Permutation, Progress, Record, SECTIONS, Section, Sink, Step, Transfer, read_sky, rests_on_operator,
};

use crate::{Error, Params, Report, neighbours, order};

/// Bytes that [`run`] takes besides its input: reordered copies of the operator and of the form factors.
///
/// An order is found without copying them; the sparse records are small beside them.
pub fn memory_needed(n: usize, channels: usize) -> u64 {
    4 * (n as u64).pow(2) * (channels as u64 + 1)
}

/// Reorders `patches.*`, `formfactor.*` and `series.*` (what there is of the last two), adds `permute.new_to_old`.
///
/// That table always leads back to the order that `voxel-simplify` chose: an earlier one is composed with the
/// new one. Optional sections that follow the order of patches and are not known are dropped and reported.
///
/// # Errors
///
/// [`Error::TooLate`] if the container already holds `pack.*`, `hmatrix.*` or `transfer.*`, [`Error::CannotReorder`],
/// those of [`order`], and [`Error::Container`].
pub fn run(
    input: &Container,
    params: &Params,
    step: Step,
    progress: &dyn Progress,
    sink: &mut Sink,
) -> Result<Report, Error> {
    let dropped = sections_to_drop(input)?;
    progress.begin("permute", 2);
    let patches = Patches::read(input)?;
    let operator = input.has("series.values").then(|| Operator::read(input)).transpose()?;
    let factors = input.has("formfactor.values").then(|| FormFactors::read(input)).transpose()?;
    let sky = input.has("formfactor.sky").then(|| read_sky(input)).transpose()?;

    let (new, mut report) = order(&patches, operator.as_ref(), params)?;
    report.zero_tiles = factors.as_ref().map(|f| neighbours::zero_tiles(f, &new));
    report.dropped = dropped;
    progress.advance(1);

    let from_first_order = if input.has("permute.new_to_old") {
        Permutation::new(new.apply(Permutation::read(input)?.new_to_old()))?
    } else {
        new.clone()
    };
    let patches = patches.permuted(&new);
    let operator = operator.map(|k| reordered(&k, &new));
    let factors =
        factors.map(|f| FormFactors { values: new.apply_to_matrix(&f.values).into(), sky: new.apply(&f.sky).into() });

    let mut builder = Builder::from_input(input, |s| !s.follows_patch_order() && !rests_on_operator(&s.name));
    patches.write(&mut builder);
    match (&factors, sky) {
        (Some(factors), _) => factors.write(&mut builder),
        (None, Some(sky)) => {
            builder.array("formfactor.sky", FLAG_REQUIRED | FLAG_PATCH_ORDER, &[sky.len()], new.apply(sky));
        }
        (None, None) => {}
    }
    if let Some(operator) = &operator {
        operator.write(&mut builder);
    }
    from_first_order.write(&mut builder);
    builder.provenance(Some(input), step)?;
    sink(&builder)?;
    progress.advance(1);
    Ok(report)
}

/// Rows and columns of every channel in the new order.
fn reordered(operator: &Operator, new: &Permutation) -> Operator<'static> {
    let mut values = Vec::with_capacity(operator.values.len());
    for channel in 0..operator.channels {
        values.append(&mut new.apply_to_matrix(operator.channel(channel)));
    }
    Operator { n: operator.n, channels: operator.channels, bounces: operator.bounces, values: values.into() }
}

/// Names of the sections that follow the order of patches and cannot be made to follow another.
fn sections_to_drop(input: &Container) -> Result<Vec<String>, Error> {
    let starts = |section: &Section, prefixes: &[&str]| prefixes.iter().any(|p| section.name.starts_with(p));
    for section in input.sections() {
        for (prefix, stage) in [
            (PackedOperator::PREFIX, "dxt-pack"),
            (HierarchicalOperator::PREFIX, "hmatrix"),
            (Transfer::PREFIX, "transfer"),
        ] {
            if starts(section, &[prefix]) {
                return Err(Error::TooLate { section: section.name.clone(), stage });
            }
        }
    }
    let reordered = |s: &Section| {
        SECTIONS.iter().any(|(name, _)| *name == s.name)
            && starts(s, &[Patches::PREFIX, FormFactors::PREFIX, Operator::PREFIX])
    };
    let unknown = |s: &&Section| s.follows_patch_order() && !reordered(s);
    let mut dropped = vec![];
    for section in input.sections().iter().filter(unknown) {
        if section.flags & FLAG_REQUIRED != 0 {
            return Err(Error::CannotReorder { section: section.name.clone() });
        }
        dropped.push(section.name.clone());
    }
    Ok(dropped)
}
