//! The packed operator of which half is stored: what its bytes mean, and what is refused.

use radfile::{Builder, Colour, NO_COMPONENT, PackedOperator, Record, half_blocks};

use crate::{
    assert_says,
    fixture::{cube, half, open},
};

#[test]
fn half_an_operator_comes_back_and_makes_version_1_2() {
    let (cube, half) = (cube(), half());
    let mut builder = Builder::new();
    cube.patches.write(&mut builder);
    half.write(&mut builder);
    let c = open(&builder);
    assert_eq!(c.version(), (1, 2));
    assert!(PackedOperator::is_in(&c) && !c.has("pack.meta"));
    assert_eq!(PackedOperator::read(&c).expect("legal"), half);
}

#[test]
fn a_grey_one_has_no_sections_of_colour() {
    let mut grey = half();
    grey.packing.channels = 1;
    grey.half = Some(Colour::default());
    let mut builder = Builder::new();
    grey.write(&mut builder);
    let c = open(&builder);
    assert_eq!(c.sections().len(), 5);
    assert_eq!(PackedOperator::read(&c).expect("legal"), grey);
    assert_eq!(grey.decode(0), grey.decode(2));
}

/// Every number of the matrix from the words of the specification, with no help of the crate.
#[test]
fn the_matrix_is_the_one_that_the_specification_describes() {
    let packed = half();
    let colour = packed.half.as_ref().expect("colour");
    let texel = |i: usize, j: usize| {
        let (i, j) = (i.max(j), i.min(j));
        let block = &packed.blocks[8 * (i / 4 * (i / 4 + 1) / 2 + j / 4)..][..8];
        let bits = u64::from_le_bytes(block.try_into().expect("eight bytes"));
        let index = bits >> (16 + 3 * (i % 4 * 4 + j % 4)) & 7;
        // The ends are 1 and 0.
        let u = [1.0, 0.0, 6.0 / 7.0, 5.0 / 7.0, 4.0 / 7.0, 3.0 / 7.0, 2.0 / 7.0, 1.0 / 7.0][index as usize];
        0.5f64 * u * u
    };
    let outlier = |i: usize, j: usize| match (i.max(j), i.min(j)) {
        (0, 0) => 0.5,
        (5, 2) => -0.125,
        (5, 5) => 2.0,
        _ => 0.0,
    };
    // U of the two components as rows of walls.
    let u = [[1.0, 0.0, 0.0], [0.0, 0.0, 0.5], [-0.25, 0.25, 0.0], [0.0, 0.0, -1.0], [0.0; 3], [0.0, 0.5, 0.0]];
    let cores = [
        [[0.5, 0.25, 0.0], [0.25, -0.5, 0.0], [0.0, 0.0, 1.0]],
        [[0.125, 0.0, 0.0], [0.0, 0.25, 0.0], [0.0, 0.0, -0.25]],
    ];
    for channel in 0..3 {
        let decoded = packed.decode(channel);
        for (at, found) in decoded.iter().enumerate() {
            let (i, j) = (at / 6, at % 6);
            let mut expected = texel(i, j) + outlier(i, j);
            for (plane, core) in cores.iter().enumerate() {
                for (a, b) in (0..3).flat_map(|a| (0..3).map(move |b| (a, b))) {
                    expected += f64::from(colour.axes[plane][channel]) * u[i][a] * core[a][b] * u[j][b];
                }
            }
            assert!((f64::from(*found) - expected).abs() < 1e-6, "K[{i}, {j}] is {found}, expected {expected}");
            assert_eq!(*found, decoded[6 * j + i], "K[{i}, {j}] and its mirror image");
        }
    }
}

/// Light between walls 0 and 1 would be colour that leaks, as they are in different components.
#[test]
fn components_exchange_no_colour() {
    let mut packed = half();
    packed.blocks.to_mut().fill(0);
    let component = packed.half.clone().expect("colour").component;
    for channel in 0..3 {
        for (at, value) in packed.decode(channel).into_iter().enumerate() {
            let (a, b) = (component[at / 6], component[at % 6]);
            let outlier = [0, 32, 17, 35].contains(&at);
            assert!(value == 0.0 || outlier || (a == b && a != NO_COMPONENT), "K[{}, {}]", at / 6, at % 6);
        }
    }
}

#[test]
fn blocks_of_the_half_are_counted() {
    assert_eq!([1, 4, 5, 6, 2638].map(half_blocks), [1, 1, 3, 3, 660 * 661 / 2]);
    let mut packed = half();
    for (n, size) in [(6, [12, 4, 1]), (2638, [4096, 856, 1]), (8192, [4096, 2732, 3])] {
        packed.packing.n = n;
        assert_eq!(packed.texture_size(), size, "{n} patches");
        packed.blocks = vec![7; 8 * half_blocks(n)].into();
        let texture = packed.texture_blocks();
        assert_eq!(texture.len(), size.map(|e| e as usize).iter().product::<usize>() / 2);
        assert_eq!(texture[..packed.blocks.len()], packed.blocks[..]);
    }
}

#[test]
fn halves_with_broken_numbers_are_refused() {
    type Break = fn(&mut PackedOperator<'static>, &mut Colour<'static>);
    let breaks: [(Break, &str); 13] = [
        (|p, _| p.packing.scale = [f32::NAN; 3], "illegal packing"),
        (|p, _| p.packing.channels = 2, "illegal packing"),
        (|p, _| p.packing.channels = 1, "one channel and planes of colour"),
        (|p, _| p.outlier_column.to_mut()[0] = 1, "row 0 has an outlier above the diagonal"),
        (|p, _| p.outlier_column.to_mut()[2] = 6, "outlier 2 lies in column 6"),
        (|p, _| p.outlier_column.to_mut()[2] = 2, "the columns of the outliers of row 5 do not increase"),
        (|p, _| p.outlier_value.to_mut()[1] = f32::INFINITY, "finite"),
        (|_, c| c.axes[1][2] = f32::NAN, "axes of colour"),
        (|_, c| c.component.to_mut()[3] = 2, "patch 3 is in component 2 of 2"),
        (|_, c| c.rank[1] = 3, "component 1 has 3 columns, expected 1 to 2, its patches"),
        (|_, c| c.rank[1] = 0, "component 1 has 0 columns, expected 1 to 2"),
        (|_, c| c.codes.to_mut().truncate(7), "(7, 8) codes and entries of cores, expected (8, 4 a plane)"),
        (|_, c| c.scale.to_mut()[1] = f32::NAN, "finite"),
    ];
    for (number, (break_it, sentence)) in breaks.into_iter().enumerate() {
        let mut broken = half();
        let mut colour = broken.half.take().expect("colour");
        break_it(&mut broken, &mut colour);
        broken.half = Some(colour);
        let mut builder = Builder::new();
        broken.write(&mut builder);
        let c = open(&builder);
        println!("{number}");
        assert_says(PackedOperator::read(&c), &["packed operator", sentence]);
    }
}
