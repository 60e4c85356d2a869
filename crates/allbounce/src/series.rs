//! `allbounce series`: form factors in, the operator of all bounces out.

use clap::error::ErrorKind;
use radfile::{Container, Patches, Progress, Record, Sink, Step};
use series::{Method, Params, Precision};

use crate::stage::Stage;

/// Sum all bounces of light into one symmetric operator.
///
/// Reads patches and form factors. Adds K = A^-1/2 X A^-1/2, one matrix for grey scenes, else one a colour.
#[derive(clap::Args)]
struct Flags {
    /// Sum only the first K bounces [default: all of them, which costs no more]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u32).range(1..=65536))]
    bounces: Option<u32>,
    /// How to sum: all bounces by cholesky, cg or paper-inverse, the first K by doubling or neumann
    /// [default: cholesky, with --bounces doubling]
    #[arg(long, value_enum)]
    method: Option<MethodName>,
    /// Numbers to compute with
    #[arg(long, value_enum, default_value = "f64")]
    precision: PrecisionName,
    /// Residual at which cg stops, relative [default: 1e-12, in f32 1e-6]
    #[arg(long, value_name = "R")]
    tolerance: Option<f64>,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum MethodName {
    /// Factors I - R W R, exact
    Cholesky,
    /// First K bounces in log2 K steps
    Doubling,
    /// First K bounces one by one, as classical radiosity
    Neumann,
    /// Conjugate gradients, column by column
    Cg,
    /// LU of I - F rho as first proposed, for comparison
    PaperInverse,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum PrecisionName {
    F32,
    F64,
}

/// What the process takes before it starts to solve: its code, patches, threads.
const PROGRAM: u64 = 10 << 20;

/// The flags as parameters that fit together.
pub struct Options(Params);

impl Options {
    /// All bounces, in the numbers that there is memory for.
    pub fn all_bounces(precision: Precision) -> Options {
        Options(Params { precision, ..Params::default() })
    }

    /// Whether it is the first bounces that are summed.
    pub fn is_cut(&self) -> bool {
        self.0.bounces.is_some()
    }
}

impl TryFrom<Flags> for Options {
    type Error = clap::Error;

    fn try_from(flags: Flags) -> Result<Options, clap::Error> {
        let method = match (flags.method, flags.bounces) {
            (None, None) | (Some(MethodName::Cholesky), _) => Method::Cholesky,
            (None, Some(_)) | (Some(MethodName::Doubling), _) => Method::Doubling,
            (Some(MethodName::Neumann), _) => Method::Neumann,
            (Some(MethodName::Cg), _) => Method::Cg,
            (Some(MethodName::PaperInverse), _) => Method::PaperInverse,
        };
        let precision = match flags.precision {
            PrecisionName::F32 => Precision::F32,
            PrecisionName::F64 => Precision::F64,
        };
        let params = Params { method, precision, bounces: flags.bounces, tolerance: flags.tolerance };
        match params.check() {
            Ok(()) => Ok(Options(params)),
            Err(error) => Err(clap::Error::raw(ErrorKind::ArgumentConflict, error.to_string())),
        }
    }
}

// By hand, so that flags that do not fit together are found before a bake starts, as a usage error.
impl clap::FromArgMatches for Options {
    fn from_arg_matches(matches: &clap::ArgMatches) -> Result<Options, clap::Error> {
        Flags::from_arg_matches(matches)?.try_into()
    }

    fn update_from_arg_matches(&mut self, matches: &clap::ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl clap::Args for Options {
    fn augment_args(command: clap::Command) -> clap::Command {
        Flags::augment_args(command)
    }

    fn augment_args_for_update(command: clap::Command) -> clap::Command {
        Flags::augment_args_for_update(command)
    }
}

impl Stage for Options {
    const NAME: &'static str = "series";
    type Report = series::Report;

    fn text(&self) -> String {
        let Params { method, bounces, precision, tolerance } = &self.0;
        let default = if bounces.is_some() { Method::Doubling } else { Method::Cholesky };
        let flags = [
            (*method != default).then(|| format!("--method {}", method.name())),
            bounces.map(|k| format!("--bounces {k}")),
            (*precision != Precision::default()).then(|| "--precision f32".to_string()),
            tolerance.map(|r| format!("--tolerance {r}")),
        ];
        flags.into_iter().flatten().collect::<Vec<_>>().join(" ")
    }

    fn memory(&self, input: &Container) -> anyhow::Result<(u64, &'static str)> {
        let patches = Patches::read(input)?;
        let channels = if patches.is_grey() { 1 } else { 3 };
        let remedy = "use fewer patches (voxel-simplify --patches N), or --precision f32";
        let container = input.as_bytes().len() as u64;
        Ok((PROGRAM + container + self.0.memory_needed(patches.len(), channels), remedy))
    }

    fn apply(&self, input: &Container, step: Step, p: &dyn Progress, sink: &mut Sink) -> anyhow::Result<Self::Report> {
        Ok(series::run(input, &self.0, step, p, sink)?)
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(clap::Parser)]
    struct Cli {
        #[command(flatten)]
        options: Options,
    }

    fn parse(flags: &str) -> Result<Options, clap::Error> {
        Cli::try_parse_from(std::iter::once("series").chain(flags.split_whitespace())).map(|cli| cli.options)
    }

    #[test]
    fn flags_are_parameters_and_provenance_repeats_them() {
        for (flags, expected) in [
            ("", Params::default()),
            ("--bounces 3", Params::first_bounces(3)),
            ("--method neumann --bounces 3", Params { method: Method::Neumann, ..Params::first_bounces(3) }),
            ("--method paper-inverse", Params { method: Method::PaperInverse, ..Params::default() }),
            ("--precision f32", Params { precision: Precision::F32, ..Params::default() }),
            (
                "--method cg --tolerance 0.001",
                Params { method: Method::Cg, tolerance: Some(1e-3), ..Params::default() },
            ),
        ] {
            let options = parse(flags).unwrap_or_else(|e| panic!("{flags}: {e}"));
            assert_eq!(options.0, expected);
            assert_eq!(options.text(), flags);
        }
        assert_eq!(parse("--method doubling --bounces 3").unwrap().text(), "--bounces 3", "one way to write it");
    }

    #[test]
    fn flags_that_do_not_fit_together_are_usage_errors_in_one_sentence() {
        for (flags, says) in [
            ("--method cholesky --bounces 3", "cholesky solves for all bounces"),
            ("--method cg --bounces 3", "cg solves for all bounces"),
            ("--method paper-inverse --bounces 3", "paper-inverse solves for all bounces"),
            ("--method doubling", "doubling sums a number of bounces"),
            ("--method neumann", "neumann sums a number of bounces"),
            ("--tolerance 0.1", "only cg has one"),
        ] {
            let error = parse(flags).map(|_| ()).expect_err(flags);
            assert_eq!(error.exit_code(), 2, "{flags}");
            let text = error.to_string();
            assert!(text.lines().next().is_some_and(|line| line.contains(says)), "{flags}: {text}");
        }
    }
}
