//! Reading of EXR channels by name, as any other program does.

use std::collections::BTreeMap;

use exr::prelude::{AnyChannels, FlatSamples, Image, Layer, SampleType, read_first_flat_layer_from_file};
use image::Rgba32FImage;

/// EXR file with one layer.
pub type Exr = Image<Layer<AnyChannels<FlatSamples>>>;

pub fn open(path: &str) -> Exr {
    read_first_flat_layer_from_file(path).expect("an EXR")
}

/// Returns the names of the channels with their types.
pub fn types(exr: &Exr) -> BTreeMap<String, SampleType> {
    let kind = |samples: &FlatSamples| match samples {
        FlatSamples::F16(_) => SampleType::F16,
        FlatSamples::F32(_) => SampleType::F32,
        FlatSamples::U32(_) => SampleType::U32,
    };
    let channels = exr.layer_data.channel_data.list.iter();
    channels.map(|channel| (channel.name.to_string(), kind(&channel.sample_data))).collect()
}

/// Returns four channels as a picture.
pub fn picture(exr: &Exr, names: [&str; 4]) -> Rgba32FImage {
    let channels = names.map(|name| {
        let named = |channel: &&exr::prelude::AnyChannel<FlatSamples>| channel.name.to_string() == name;
        let channel = exr.layer_data.channel_data.list.iter().find(named);
        let channel = channel.unwrap_or_else(|| panic!("no {name} in {:?}", types(exr)));
        channel.sample_data.values_as_f32().collect::<Vec<f32>>()
    });
    let size = exr.layer_data.size;
    Rgba32FImage::from_fn(size.x() as u32, size.y() as u32, |x, y| {
        let at = y as usize * size.x() + x as usize;
        image::Rgba(std::array::from_fn(|channel| channels[channel][at]))
    })
}

/// Reads the beauty of a file.
pub fn beauty(path: &str) -> Rgba32FImage {
    picture(&open(path), ["R", "G", "B", "A"])
}
