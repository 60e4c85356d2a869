//! Random containers come back as they were; random damage with right checksums never panics.

use radfile::{
    Accuracy, Builder, Container, Elements, FLAG_PATCH_ORDER, FormFactors, Gathered, Lightmap, Materials, Mesh,
    Operator, PackedOperator, Patches, Permutation, Provenance, Record, Tolerance, Transfer, Volume, Weights,
};

use crate::{
    fixture::{
        Extras, accuracy, cube, cube_with_cuts, elements, every_feature, gathered_by_volume, half, lightmap, open,
        volume,
    },
    raw::{ENTRY, HEADER, LENGTH, OFFSET, SHAPE, edited, field, u32_at, u64_at},
};

/// Marsaglia's xorshift64*, so that a failure can be repeated.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_F491_4F6C_DD1D)
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }

    /// Numbers that programs stumble over, or any.
    fn number(&mut self) -> u64 {
        let special = [0, 1, 2, 3, 0x7F, 0xFF, 0x7FFF_FFFF, 0x8000_0000, 0xFFFF_FFFF, 1 << 61, 1 << 63, u64::MAX];
        match self.below(3) {
            0 => special[self.below(special.len())],
            1 => 0x7FC0_0000, // no number, as f32
            _ => self.next(),
        }
    }
}

#[test]
fn random_containers_come_back_as_they_were() {
    let mut random = Random(0x5EED);
    for _ in 0..300 {
        let mut builder = Builder::new();
        let mut written: Vec<(String, Vec<usize>, Vec<u16>)> = Vec::new();
        for i in 0..random.below(12) {
            let shape: Vec<usize> = (0..random.below(5)).map(|_| random.below(5)).collect();
            let data: Vec<u16> = (0..shape.iter().product::<usize>()).map(|_| random.next() as u16).collect();
            let name = format!("x-{i}");
            builder.array(&name, random.below(2) as u32 * FLAG_PATCH_ORDER, &shape, data.clone());
            written.push((name, shape, data));
        }
        let container = open(&builder);
        assert_eq!(container.sections().len(), written.len());
        for (name, shape, data) in &written {
            let (read, extents) = container.array::<u16>(name, shape.len()).expect("written");
            assert_eq!((read, extents.len()), (&data[..], shape.len()));
            assert!(extents.iter().zip(shape).all(|(&e, &s)| e == s as u64));
        }
        assert_eq!(Builder::from_input(&container, |_| true).to_bytes(), container.as_bytes());
    }
}

/// Reads every record and does with it what the stages do.
fn use_everything(c: &Container) -> u32 {
    let mut legal = 0;
    legal += u32::from(Mesh::read(c).is_ok());
    legal += u32::from(Materials::read(c).is_ok());
    legal += u32::from(c.meta::<Extras>("scene.extras").is_ok());
    legal += u32::from(Provenance::read(c).is_ok());
    if let Ok(patches) = Patches::read(c) {
        let order = Permutation::read(c).unwrap_or_else(|_| Permutation::identity(patches.len()));
        assert_eq!(patches.permuted(&order).len(), patches.len());
        for face in 0..patches.locator.face_start.len() as u32 - 1 {
            for point in [[0.5; 3], [f32::NAN; 3], [f32::MAX; 3], [-1e30, 0.0, f32::INFINITY]] {
                let patch = patches.locator.patch_at(face, point);
                assert!(patch.is_none_or(|p| (p as usize) < patches.len()));
            }
        }
        legal += 1;
    }
    if let Ok(factors) = FormFactors::read(c) {
        assert!((0..factors.len()).all(|i| factors.row(i).len() == factors.len()));
        legal += 1;
    }
    if let Ok(operator) = Operator::read(c) {
        assert_eq!(operator.channel(2).len(), operator.n * operator.n);
        legal += 1;
    }
    if let Ok(packed) = PackedOperator::read(c) {
        (0..3).for_each(|channel| assert!(packed.decode(channel).iter().all(|v| !v.is_nan())));
        legal += 1;
    }
    if let Ok(transfer) = Transfer::read(c) {
        let patches = c.array::<f32>("patches.area", 1).expect("the record checked it").0.len();
        if let Weights::Interpolated(rows) = &transfer.weights {
            assert_eq!(rows.gather(&vec![[1.0; 3]; patches]).len(), rows.len());
        }
        legal += 1;
    }
    legal += u32::from(Elements::read(c).is_ok());
    if let Ok(lightmap) = Lightmap::read(c) {
        assert_eq!(lightmap.fill(&vec![[1.0; 3]; lightmap.receivers()]).len(), lightmap.receiver.len());
        legal += 1;
    }
    if let Ok(volume) = Volume::read(c) {
        assert_eq!(volume.fill(&vec![[1.0; 3]; volume.receivers()]).len(), volume.cells());
        legal += u32::from(Gathered::read(c, Volume::PREFIX, volume.receivers()).is_ok());
    }
    legal += u32::from(Accuracy::read(c).is_ok());
    legal
}

#[test]
fn random_contents_with_right_checksums_never_panic() {
    let (cut, half) = (cube_with_cuts(), half());
    let mut halved = Builder::new();
    half.write(&mut halved);
    damage(&cut.builder(), 20_000, [1000, 10_000]);
    damage(&halved, 5_000, [200, 500]);
    let (cube, elements, lightmap) = (cube(), elements(), lightmap());
    let (volume, of_volume, accuracy) = (volume(), gathered_by_volume(), accuracy());
    let mut receivers = Builder::new();
    cube.mesh.write(&mut receivers);
    cube.patches.write(&mut receivers);
    elements.write(&mut receivers);
    lightmap.write(&mut receivers);
    volume.write(&mut receivers);
    of_volume.write(&mut receivers, Volume::PREFIX, 0);
    accuracy.write(&mut receivers);
    damage(&receivers, 10_000, [500, 2_000]);
}

/// Damages a file in many ways; so many must be refused, and so many records legal.
fn damage(builder: &Builder, rounds: usize, least: [u32; 2]) {
    let (file, whole) = (builder.to_bytes(), open(builder));
    let sections = u32_at(&file, 12) as usize;
    let mut random = Random(0xC0FFEE);
    let (mut refused, mut legal) = (0, 0);
    for _ in 0..rounds {
        let entry = random.below(sections);
        let (offset, length) = (u64_at(&file, field(entry, OFFSET)), u64_at(&file, field(entry, LENGTH)));
        let damaged = edited(&file, |bytes| {
            for _ in 0..1 + random.below(3) {
                let value = random.number().to_le_bytes();
                let width = [1, 4, 8][random.below(3)];
                let at = match random.below(8) {
                    0 => HEADER + random.below(sections * ENTRY),
                    1 => field(entry, SHAPE) + 8 * random.below(4),
                    _ => offset as usize + random.below(length.max(1) as usize) / width * width,
                };
                bytes[at..at + width].copy_from_slice(&value[..width]);
            }
        });
        match Container::from_bytes(&damaged) {
            Err(_) => refused += 1,
            Ok(container) => {
                legal += use_everything(&container);
                radfile::diff(&whole, &container, Tolerance::EXACT);
                radfile::diff(&container, &whole, Tolerance::EXACT);
            }
        }
    }
    assert!(
        refused > least[0] && legal > least[1],
        "{refused} refused and {legal} records read: the test tests too little"
    );
}

/// Shapes that multiply to nothing may be as large as they like.
#[test]
fn empty_sections_of_absurd_shapes_never_panic() {
    let file = cube_with_cuts().builder().to_bytes();
    let container = open(&cube_with_cuts().builder());
    const LARGE: usize = usize::MAX / 12;
    let shapes: [&[usize]; 6] = [&[0], &[0, 3], &[LARGE, 0], &[0, LARGE, 3], &[1, LARGE, 0], &[3, 0, 0]];
    for section in container.sections() {
        for shape in shapes {
            let mut builder = Builder::from_input(&container, |_| true);
            builder.array::<f32>(&section.name, section.flags, shape, vec![]);
            use_everything(&open(&builder));
            builder.array::<u32>(&section.name, section.flags, shape, vec![]);
            use_everything(&open(&builder));
        }
    }
    assert_eq!(use_everything(&open(&every_feature())), 1, "only its provenance is a record");
    assert_eq!(file, container.as_bytes());
}
