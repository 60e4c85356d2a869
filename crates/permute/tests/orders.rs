//! The orders themselves.

mod common;

use common::{Random, scene};
use permute::{Error, Order, Params, order, zero_tiles};
use radfile::{Operator, Patches, Permutation};

fn points(position: Vec<[f32; 3]>) -> Patches {
    let n = position.len();
    let mut random = Random(n as u64 + 1);
    let normal = (0..n).map(|_| std::array::from_fn(|_| random.next() as f32 - 0.5)).collect();
    Patches { position, normal, area: vec![1.0; n], ..Patches::default() }
}

fn random_operator(n: usize, channels: usize) -> Operator<'static> {
    let mut random = Random(3);
    let values: Vec<f32> = (0..channels * n * n).map(|_| random.next() as f32).collect();
    Operator { n, channels, bounces: None, values: values.into() }
}

#[test]
fn every_order_names_every_patch_once_whatever_the_scene() {
    let mut random = Random(1);
    let cloud: Vec<[f32; 3]> = (0..300).map(|_| std::array::from_fn(|_| random.next() as f32 * 9.0 - 4.0)).collect();
    let scenes = [
        ("a cloud", cloud.clone()),
        ("a plane", cloud.iter().map(|p| [p[0], 1.0, p[2]]).collect()),
        ("a line", cloud.iter().map(|p| [2.0, p[1], 1.0]).collect()),
        ("one place", vec![[3.0, 3.0, 3.0]; 40]),
        ("some places twice", cloud.iter().take(50).flat_map(|&p| [p, p]).collect()),
        ("far away", cloud.iter().map(|p| p.map(|v| v * 1e30)).collect()),
        ("a single patch", vec![[1.0, 2.0, 3.0]]),
        ("no patch", vec![]),
    ];
    for (name, position) in scenes {
        let patches = points(position);
        for kind in Order::ALL {
            let (found, report) =
                order(&patches, Some(&random_operator(patches.len(), 1)), &Params { order: kind }).unwrap();
            // Permutation::new refuses anything that is no permutation of its own length.
            assert_eq!(found.new_to_old().len(), patches.len(), "{name}, {}", kind.name());
            assert_eq!((report.patches, report.order), (patches.len(), kind.name()));
        }
    }
}

#[test]
fn none_moves_nothing_and_patches_that_cannot_be_told_apart_stay() {
    let (patches, _, operator) = scene(4);
    let (found, report) = order(&patches, Some(&operator), &Params { order: Order::None }).unwrap();
    assert_eq!((found, report.moved), (Permutation::identity(patches.len()), 0));
    let difference = report.neighbour_difference.unwrap();
    assert_eq!(difference.before, difference.after);

    let same = Patches { normal: vec![[0.0, 0.0, 1.0]; 9], ..points(vec![[1.0; 3]; 9]) };
    let dark = Operator { n: 9, channels: 1, bounces: None, values: vec![0.0; 81].into() };
    for kind in [Order::Hilbert, Order::Morton, Order::NormalHilbert, Order::Greedy] {
        let (found, _) = order(&same, Some(&dark), &Params { order: kind }).unwrap();
        assert_eq!(found, Permutation::identity(9), "{}", kind.name());
    }
}

#[test]
fn normals_come_first_and_space_second() {
    let position = vec![[0.0; 3], [0.1, 0.0, 0.0], [5.0, 0.0, 0.0], [5.1, 0.0, 0.0]];
    let up = [0.0, 0.0, 1.0];
    let down = [0.0, 0.0, -1.0];
    let patches = Patches { normal: vec![down, up, down, up], ..points(position) };
    let (found, _) = order(&patches, None, &Params::default()).unwrap();
    assert_eq!(found.new_to_old(), [1, 3, 0, 2]);
}

#[test]
fn greedy_follows_the_most_similar_row_from_the_brightest_on() {
    // Rows are points on a line in the first column; up to 32 patches the comparison is exact.
    let along = [4.0, 1.0, 9.0, 7.5, 0.5, 2.0];
    let n = along.len();
    let mut values = vec![0.0; n * n];
    (0..n).for_each(|i| values[i * n] = along[i]);
    let operator = Operator { n, channels: 1, bounces: None, values: values.into() };
    let (found, _) = order(&points(vec![[0.0; 3]; n]), Some(&operator), &Params { order: Order::Greedy }).unwrap();
    assert_eq!(found.new_to_old(), [2, 3, 0, 5, 1, 4]);
}

#[test]
fn greedy_finds_hidden_groups_of_equal_rows() {
    // 200 patches in 5 groups that exchange light with one group each, shuffled.
    let n = 200;
    let mut random = Random(9);
    let group: Vec<usize> = (0..n).map(|_| (random.next() * 5.0) as usize).collect();
    let level = [1.0, 0.8, 0.6, 0.4, 0.2];
    let value = |at: usize| if group[at / n] == group[at % n] { level[group[at / n]] } else { 0.0 };
    let operator =
        Operator { n, channels: 1, bounces: None, values: (0..n * n).map(value).collect::<Vec<f32>>().into() };
    let (found, report) = order(&points(vec![[0.0; 3]; n]), Some(&operator), &Params { order: Order::Greedy }).unwrap();
    let sequence: Vec<usize> = found.new_to_old().iter().map(|&i| group[i as usize]).collect();
    let changes = sequence.windows(2).filter(|w| w[0] != w[1]).count();
    assert_eq!(changes, 4, "{sequence:?}");
    let difference = report.neighbour_difference.unwrap();
    assert!(difference.after < 0.05 * difference.random, "{difference:?}");
}

#[test]
fn neighbours_that_face_alike_and_lie_close_see_alike() {
    let (patches, factors, operator) = scene(8);
    let of = |kind| order(&patches, Some(&operator), &Params { order: kind }).unwrap();
    let mut after = std::collections::BTreeMap::new();
    for kind in Order::ALL {
        let (found, report) = of(kind);
        let d = report.neighbour_difference.unwrap();
        println!("{:16} {d:?} {:?}", kind.name(), zero_tiles(&factors, &found));
        after.insert(kind.name(), d.after);
        // The scene comes shuffled: its order is as bad as a random one.
        assert!((d.before / d.random - 1.0).abs() < 0.05, "{d:?}");
    }
    assert!(after["normal-hilbert"] < 0.5 * after["none"], "{after:?}");
    assert!(after["greedy"] < 0.5 * after["none"], "{after:?}");
    assert!(after["hilbert"] < after["morton"] && after["morton"] < after["none"], "{after:?}");
    assert!(after["normal-hilbert"] < after["hilbert"], "{after:?}");
}

#[test]
fn pairs_that_exchange_nothing_gather_in_tiles() {
    let (patches, factors, _) = scene(8);
    let (found, _) = order(&patches, None, &Params::default()).unwrap();
    let tiles = zero_tiles(&factors, &found);
    // Two rooms that do not see each other, and walls that do not see themselves.
    assert!(tiles.before < 0.01 && tiles.after > 0.4, "{tiles:?}");
}

#[test]
fn neighbour_differences_are_what_they_say() {
    // Rows 1 3 / 3 0: to the right |1−3| + |3−0|, down |1−3| + |3−0|: 10 over 4 pairs; mean value 7/4.
    let operator = Operator { n: 2, channels: 1, bounces: None, values: vec![1.0, 3.0, 3.0, 0.0].into() };
    let (_, report) = order(&points(vec![[0.0; 3]; 2]), Some(&operator), &Params { order: Order::None }).unwrap();
    assert_eq!(report.neighbour_difference.unwrap().before, 10.0 / 4.0 / (7.0 / 4.0));
}

#[test]
fn any_number_of_threads_finds_the_same_order() {
    let (patches, factors, _) = scene(6);
    let operator = random_operator(patches.len(), 3);
    for kind in Order::ALL {
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let (found, report) = order(&patches, Some(&operator), &Params { order: kind }).unwrap();
                let tiles = zero_tiles(&factors, &found);
                (found, format!("{report:?} {tiles:?}"))
            })
        };
        let one = with(1);
        assert!([2, 3, 8].iter().all(|&threads| with(threads) == one), "{}", kind.name());
    }
}

#[test]
fn orders_have_names_and_others_are_refused() {
    for kind in Order::ALL {
        assert_eq!(kind.name().parse::<Order>().unwrap(), kind);
    }
    let text = "fiedler".parse::<Order>().unwrap_err().to_string();
    assert_eq!(text, "there is no order `fiedler`, expected one of normal-hilbert, hilbert, morton, greedy, none");
}

#[test]
fn greedy_without_an_operator_and_an_operator_of_other_patches_are_refused() {
    let patches = points(vec![[0.0; 3]; 4]);
    let error = order(&patches, None, &Params { order: Order::Greedy }).unwrap_err();
    assert!(matches!(error, Error::NeedsOperator));
    assert!(error.to_string().contains("run `allbounce series` first"), "{error}");
    let error = order(&patches, Some(&random_operator(5, 1)), &Params::default()).unwrap_err();
    assert!(error.to_string().starts_with("an operator of 5 patches, but there are 4"), "{error}");
}
