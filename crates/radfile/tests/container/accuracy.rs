//! What a bake was measured to be: read as it was written, refused where it is broken, dropped where it is stale.

use radfile::{Accuracy, Builder, Container, Record, outlasts_packing, rests_on_operator};

use crate::{
    assert_says,
    fixture::{accuracy, open},
};

fn written(accuracy: &Accuracy) -> Container {
    let mut builder = Builder::new();
    accuracy.write(&mut builder);
    open(&builder)
}

#[test]
fn an_accuracy_is_read_as_it_was_written_and_makes_version_1_4() {
    let limited = Accuracy { error_wanted: None, lights: vec![], ..accuracy() };
    for a in [accuracy(), limited] {
        let c = written(&a);
        assert_eq!(Accuracy::read(&c).expect("legal"), a);
        assert_eq!(c.version(), (1, 4));
        // A reader that does not know it can do without.
        assert!(c.sections().iter().all(|s| s.flags == 0));
    }
}

#[test]
fn errors_that_are_no_shares_are_refused() {
    type Case = (fn(&mut Accuracy), &'static str);
    let cases: &[Case] = &[
        (|a| a.error_wanted = Some(0.0), "accuracy: an error of 0 was asked for, expected a share above 0, up to 1"),
        (|a| a.error_wanted = Some(1.5), "accuracy: an error of 1.5 was asked for"),
        (|a| a.error_wanted = Some(f64::NAN), "accuracy: an error of NaN was asked for"),
        (|a| a.rms = f64::NAN, "accuracy: the rms of all lights is NaN, expected a finite number, 0 or more"),
        (|a| a.rms = -0.1, "accuracy: the rms of all lights is -0.1"),
        (|a| a.vis99 = f64::INFINITY, "accuracy: the 99th percentile of all lights is inf"),
        (|a| a.bias = f64::NEG_INFINITY, "accuracy: the bias of all lights is -inf, expected a finite number"),
        (|a| a.lights[1].rms = -1.0, "accuracy: the rms of light 1 is -1"),
        (|a| a.lights[0].vis99 = f64::NAN, "accuracy: the 99th percentile of light 0 is NaN"),
        (|a| a.lights[1].bias = f64::NAN, "accuracy: the bias of light 1 is NaN"),
        (|a| a.lights[0].noise = -1e-9, "accuracy: the noise of light 0 is -0.000000001"),
        (|a| a.parts.discretisation = f64::NAN, "accuracy: the error of discretisation is NaN"),
        (|a| a.parts.form_factors = -1.0, "accuracy: the error of form factors is -1"),
        (|a| a.parts.solver = f64::INFINITY, "accuracy: the error of solver is inf"),
        (|a| a.parts.packing = f64::NAN, "accuracy: the error of packing is NaN"),
        (|a| a.parts.receivers = -2.0, "accuracy: the error of receivers is -2"),
    ];
    for (break_it, said) in cases {
        let mut a = accuracy();
        break_it(&mut a);
        assert_says(Accuracy::read(&written(&a)), &[said]);
    }
}

/// Counts that the section cannot hold neither reserve memory nor abort.
#[test]
fn absurd_numbers_of_lights_are_refused() {
    for count in [1, 1 << 40, u64::MAX] {
        let mut builder = Builder::new();
        builder.meta("accuracy.meta", 0, &(Some(0.05), 800u32, [0.03, 0.0, 0.1], count));
        assert_says(
            Accuracy::read(&open(&builder)),
            &["metadata of accuracy.meta cannot be decoded: it ends too early"],
        );
    }
}

#[test]
fn a_new_operator_or_packing_outdates_it() {
    assert!(rests_on_operator("accuracy.meta"));
    assert!(!outlasts_packing("accuracy.meta", false) && !outlasts_packing("accuracy.meta", true));
    assert!(outlasts_packing("transfer.position", false) && outlasts_packing("x-accuracy", false));
}
