//! The film adds exactly, its files are whole, and what they hold comes back.

#[cfg(target_os = "linux")]
#[path = "common/small_disk.rs"]
mod small_disk;

mod film {
    mod coverage;
    mod damage;
    mod files;
    mod sums;
}

use ondine::film::{AovSample, AovSet, BLOCK, Film, Layers, Region};

/// SplitMix64 (Steele et al. 2014).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// In [0, 1).
    pub(crate) fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1u64 << 24) as f32
    }

    /// From 2^-20 to 2^12, as likely in each octave.
    pub(crate) fn radiance(&mut self) -> f32 {
        (self.unit() * 32.0 - 20.0).exp2()
    }

    pub(crate) fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i + 1));
        }
    }
}

pub(crate) const ALL: AovSet = AovSet {
    albedo: true,
    normal: true,
    depth: true,
    lengths: 2,
};

/// One call of [`Film::add`].
pub(crate) struct Wave {
    pub(crate) tile: Region,
    pub(crate) samples: u32,
    pub(crate) radiance: Vec<[f32; 4]>,
    pub(crate) aovs: Vec<AovSample>,
    pub(crate) by_length: [Vec<[f32; 4]>; 2],
}

impl Wave {
    pub(crate) fn add_to(&self, film: &Film) {
        let layers = Layers {
            first_hits: &self.aovs,
            by_length: &self.by_length,
        };
        film.add(self.tile, self.samples, &self.radiance, layers);
    }
}

/// The waves of `region`, cut into small tiles, `spp` samples a pixel; each sample a function of pixel and number alone.
pub(crate) fn waves(region: Region, spp: u32) -> Vec<Wave> {
    let mut all = Vec::new();
    for first in (0..spp).step_by(BLOCK as usize) {
        for y0 in (region.y0..region.y1).step_by(5) {
            for x0 in (region.x0..region.x1).step_by(7) {
                let (x1, y1) = (region.x1.min(x0 + 7), region.y1.min(y0 + 5));
                let tile = Region { x0, y0, x1, y1 };
                all.push(wave(tile, first, BLOCK.min(spp - first)));
            }
        }
    }
    all
}

fn wave(tile: Region, first: u32, samples: u32) -> Wave {
    let (mut radiance, mut aovs) = (Vec::new(), Vec::new());
    let mut by_length = [Vec::new(), Vec::new()];
    for (x, y) in tile.coordinates() {
        for sample in first..first + samples {
            let mut random = Random(u64::from(x) << 40 | u64::from(y) << 20 | u64::from(sample));
            radiance.push([
                random.radiance(),
                random.radiance(),
                random.radiance(),
                f32::NAN, // padding is not looked at
            ]);
            for of_length in &mut by_length {
                of_length.push([random.radiance(), 0.0, -random.radiance(), f32::NAN]);
            }
            aovs.push(AovSample {
                albedo: [random.unit(), random.unit(), random.unit()],
                normal: [
                    random.unit() - 0.5,
                    random.unit() - 0.5,
                    random.unit() - 0.5,
                ],
                depth: random.radiance(),
            });
        }
    }
    Wave {
        tile,
        samples,
        radiance,
        aovs,
        by_length,
    }
}

/// A film with `spp` samples in each pixel of `region`.
pub(crate) fn filled(width: u32, height: u32, region: Region, spp: u32) -> Film {
    let film = Film::new(width, height, region, ALL).unwrap();
    for wave in waves(region, spp) {
        wave.add_to(&film);
    }
    film
}

/// Whether layers agree too, which the image hash leaves out.
pub(crate) fn assert_same(a: &Film, b: &Film) {
    assert_eq!((a.region(), a.aovs()), (b.region(), b.aovs()));
    assert_eq!(a.image_hash(), b.image_hash());
    for (x, y) in a.region().coordinates() {
        assert_eq!(a.aov(x, y), b.aov(x, y));
        for length in 1..=a.aovs().lengths {
            let [a, b] = [a, b].map(|film| film.sums_of_length(length, x, y));
            assert_eq!(a, b);
        }
    }
}
