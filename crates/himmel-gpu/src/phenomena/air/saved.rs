//! Finished tables as bytes, and those that are kept on the GPU: no air is built twice.
//!
//! A file is a head of [`HEAD`] bytes (a mark with the version of the format, the key, a checksum) and the floats of the optical
//! depth, the moments and the ground's irradiance, row by row. Half a megabyte at `high`.

use sha2::{Digest, Sha256};

use super::sizes::AirSizes;
use super::tables::{Tables, texture_bytes};
use crate::error::GpuError;
use crate::shader;

/// The first bytes of a file; the last one is the version of the format.
const MARK: &[u8; 8] = b"HIMMELA\x01";
/// Bytes before the floats: mark, key, checksum.
const HEAD: usize = 8 + 32 + 32;
/// Shaders whose text decides what is in the tables.
const SHADERS: [&str; 5] = [
    "phenomena/air/depth.wgsl",
    "phenomena/air/build/rays.wgsl",
    "phenomena/air/build/first.wgsl",
    "phenomena/air/build/next.wgsl",
    "phenomena/air/build/resolve.wgsl",
];

/// A hash of everything that the tables are made of: medium, sizes, orders, text of the shaders, GPU and driver, version of the
/// format. Shown as 64 hexadecimal digits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TablesKey([u8; 32]);

impl TablesKey {
    pub(crate) fn new(
        sizes: &AirSizes,
        tables: &Tables,
        body: usize,
        adapter: &wgpu::AdapterInfo,
    ) -> Result<Self, GpuError> {
        let mut hash = Sha256::new_with_prefix(MARK);
        let mut part = |bytes: &[u8]| {
            hash.update((bytes.len() as u64).to_le_bytes());
            hash.update(bytes);
        };
        // Floats are kept as the machine has them.
        part(&1f32.to_ne_bytes());
        part(format!("{sizes:?}").as_bytes());
        part(tables.fingerprint(body));
        for table in tables.computed(body) {
            part(format!("{:?} {:?}", table.size, table.texture.format()).as_bytes());
        }
        for root in SHADERS {
            part(shader::module(root)?.as_bytes());
        }
        part(format!("{} {:?} {} {}", adapter.name, adapter.backend, adapter.driver, adapter.driver_info).as_bytes());
        Ok(Self(hash.finalize().into()))
    }
}

impl std::fmt::Display for TablesKey {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

/// What of a table belongs to one body.
#[derive(Clone, Copy)]
pub(crate) struct Part<'a> {
    texture: &'a wgpu::Texture,
    origin: wgpu::Origin3d,
    size: wgpu::Extent3d,
}

impl<'a> Part<'a> {
    pub(crate) fn layers(texture: &'a wgpu::Texture, first: u32, count: u32) -> Self {
        let size = wgpu::Extent3d { depth_or_array_layers: count, ..texture.size() };
        Self { texture, origin: wgpu::Origin3d { x: 0, y: 0, z: first }, size }
    }

    pub(crate) fn row(texture: &'a wgpu::Texture, row: u32) -> Self {
        let size = wgpu::Extent3d { height: 1, ..texture.size() };
        Self { texture, origin: wgpu::Origin3d { x: 0, y: row, z: 0 }, size }
    }

    fn whole(texture: &'a wgpu::Texture) -> Self {
        Self { texture, origin: wgpu::Origin3d::ZERO, size: texture.size() }
    }

    fn place(&self) -> wgpu::TexelCopyTextureInfo<'a> {
        wgpu::TexelCopyTextureInfo { origin: self.origin, ..self.texture.as_image_copy() }
    }

    /// Bytes of a row, and rows.
    fn rows(&self) -> (usize, usize) {
        (self.size.width as usize * 16, (self.size.height * self.size.depth_or_array_layers) as usize)
    }

    fn bytes(&self) -> usize {
        let (row, count) = self.rows();
        row * count
    }
}

fn padded(row: usize) -> usize {
    row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT as usize)
}

/// Tables on their way from the GPU.
pub struct TablesReadBack {
    device: wgpu::Device,
    buffer: wgpu::Buffer,
    key: TablesKey,
    /// Bytes of a row and number of rows of each table.
    rows: Vec<(usize, usize)>,
    answer: std::sync::mpsc::Receiver<Result<(), wgpu::BufferAsyncError>>,
}

impl TablesReadBack {
    pub(crate) fn new(device: &wgpu::Device, queue: &wgpu::Queue, key: TablesKey, tables: [Part<'_>; 3]) -> Self {
        let rows: Vec<_> = tables.iter().map(Part::rows).collect();
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("air tables, read back"),
            size: rows.iter().map(|&(row, count)| (padded(row) * count) as u64).sum(),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder =
            device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("air tables, read back") });
        let mut offset = 0;
        for (table, &(row, count)) in tables.iter().zip(&rows) {
            let layout = wgpu::TexelCopyBufferLayout {
                offset,
                bytes_per_row: Some(padded(row) as u32),
                rows_per_image: Some(table.size.height),
            };
            let destination = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
            encoder.copy_texture_to_buffer(table.place(), destination, table.size);
            offset += (padded(row) * count) as u64;
        }
        let (sender, answer) = std::sync::mpsc::channel();
        encoder.map_buffer_on_submit(&buffer, wgpu::MapMode::Read, .., move |result| {
            // Nobody listens once the read-back is dropped.
            let _ = sender.send(result);
        });
        queue.submit([encoder.finish()]);
        Self { device: device.clone(), buffer, key, rows, answer }
    }

    /// What they are made of.
    pub fn key(&self) -> TablesKey {
        self.key
    }

    /// The file's bytes once they have arrived. Does not wait.
    pub fn poll(&mut self) -> Option<Result<Vec<u8>, GpuError>> {
        let failed = |error: &dyn std::fmt::Display| Some(Err(GpuError::Device(error.to_string())));
        if let Err(error) = self.device.poll(wgpu::PollType::Poll) {
            return failed(&error);
        }
        match self.answer.try_recv() {
            Ok(Ok(())) => Some(Ok(self.bytes())),
            Ok(Err(error)) => failed(&error),
            Err(std::sync::mpsc::TryRecvError::Empty) => None,
            Err(error) => failed(&error),
        }
    }

    /// The file's bytes, waiting for them; not on the web, where nothing may wait.
    pub fn wait(self) -> Result<Vec<u8>, GpuError> {
        let failed = |error: &dyn std::fmt::Display| GpuError::Device(error.to_string());
        self.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| failed(&error))?;
        match self.answer.recv_timeout(std::time::Duration::from_secs(60)) {
            Ok(Ok(())) => Ok(self.bytes()),
            Ok(Err(error)) => Err(failed(&error)),
            Err(error) => Err(failed(&error)),
        }
    }

    fn bytes(&self) -> Vec<u8> {
        let mut floats = Vec::new();
        {
            let mapped = self.buffer.slice(..).get_mapped_range();
            let mut rest: &[u8] = &mapped;
            for &(row, count) in &self.rows {
                let (table, after) = rest.split_at(padded(row) * count);
                table.chunks_exact(padded(row)).for_each(|padded| floats.extend_from_slice(&padded[..row]));
                rest = after;
            }
        }
        self.buffer.unmap();
        let mut file = Vec::with_capacity(HEAD + floats.len());
        file.extend_from_slice(MARK);
        file.extend_from_slice(&self.key.0);
        file.extend_from_slice(&Sha256::digest(&floats));
        file.extend_from_slice(&floats);
        file
    }
}

/// The floats of a file that is whole and has the key, `length` bytes of them.
///
/// Laws tested: what was saved is read; no cut and no changed bit is.
fn floats_of<'a>(key: &TablesKey, length: usize, bytes: &'a [u8]) -> Result<&'a [u8], GpuError> {
    let wrong = |why: &str| Err(GpuError::Tables(format!("{why}; they will be built")));
    if bytes.len() < HEAD || bytes[..7] != MARK[..7] {
        return wrong("this is no file of saved tables");
    }
    let (head, floats) = bytes.split_at(HEAD);
    if head[7] != MARK[7] {
        return wrong("the file is of another version of Himmel");
    }
    if head[8..40] != key.0 {
        return wrong("the file holds other air, other sizes, or tables of another GPU or version");
    }
    if floats.len() != length {
        return wrong(&format!("the file has {} bytes of tables where {length} belong: it was cut", floats.len()));
    }
    if head[40..] != Sha256::digest(floats)[..] {
        return wrong("the file is damaged");
    }
    Ok(floats)
}

pub(crate) fn load(queue: &wgpu::Queue, key: &TablesKey, tables: [Part<'_>; 3], bytes: &[u8]) -> Result<(), GpuError> {
    let length = tables.iter().map(Part::bytes).sum();
    let mut rest = floats_of(key, length, bytes)?;
    for table in tables {
        let (floats, after) = rest.split_at(table.bytes());
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(table.rows().0 as u32),
            rows_per_image: Some(table.size.height),
        };
        queue.write_texture(table.place(), floats, layout, table.size);
        rest = after;
    }
    Ok(())
}

/// Finished tables of airs that are not in hand, the one that was left last at the end.
#[derive(Default)]
pub(crate) struct Kept {
    capacity: usize,
    airs: Vec<(TablesKey, [wgpu::Texture; 3])>,
}

impl Kept {
    pub(crate) fn capacity(&self) -> usize {
        self.capacity
    }

    pub(crate) fn set_capacity(&mut self, capacity: usize) {
        self.capacity = capacity;
        let surplus = self.airs.len().saturating_sub(capacity);
        self.airs.drain(..surplus);
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.airs.iter().flat_map(|(_, textures)| textures).map(texture_bytes).sum()
    }

    /// Copies tables that are about to be overwritten.
    pub(crate) fn keep(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, key: TablesKey, tables: [Part<'_>; 3]) {
        if let Some(known) = self.airs.iter().position(|(other, _)| *other == key) {
            let air = self.airs.remove(known);
            self.airs.push(air);
            return;
        }
        let copies = tables.map(|table| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some("kept table"),
                size: table.size,
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: table.texture.format(),
                usage: wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::COPY_DST,
                view_formats: &[],
            })
        });
        copy(device, queue, tables, copies.each_ref().map(Part::whole));
        self.airs.push((key, copies));
        self.set_capacity(self.capacity);
    }

    /// Copies tables back; false if there are none of that key.
    pub(crate) fn restore(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        key: &TablesKey,
        tables: [Part<'_>; 3],
    ) -> bool {
        let Some((_, kept)) = self.airs.iter().find(|(other, _)| other == key) else { return false };
        copy(device, queue, kept.each_ref().map(Part::whole), tables);
        true
    }
}

fn copy(device: &wgpu::Device, queue: &wgpu::Queue, from: [Part<'_>; 3], to: [Part<'_>; 3]) {
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("kept tables") });
    for (from, to) in from.into_iter().zip(to) {
        encoder.copy_texture_to_texture(from.place(), to.place(), from.size);
    }
    queue.submit([encoder.finish()]);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(key: &TablesKey, floats: &[u8]) -> Vec<u8> {
        [&MARK[..], &key.0, &Sha256::digest(floats), floats].concat()
    }

    #[test]
    fn a_file_that_is_cut_or_changed_is_refused() {
        let key = TablesKey([7; 32]);
        let floats: Vec<u8> = (0..640u32).flat_map(|i| (i as f32).to_ne_bytes()).collect();
        let whole = file(&key, &floats);
        assert_eq!(floats_of(&key, floats.len(), &whole).unwrap(), floats);
        for length in (0..whole.len()).chain([whole.len() + 1]) {
            let mut cut = whole.clone();
            cut.resize(length, 0);
            assert!(floats_of(&key, floats.len(), &cut).is_err(), "{length} bytes");
        }
        for bit in 0..8 * whole.len() {
            let mut changed = whole.clone();
            changed[bit / 8] ^= 1 << (bit % 8);
            let error = floats_of(&key, floats.len(), &changed).unwrap_err().to_string();
            assert!(error.ends_with("they will be built"), "{error}");
        }
        assert!(floats_of(&TablesKey([8; 32]), floats.len(), &whole).unwrap_err().to_string().contains("other air"));
        assert!(floats_of(&key, floats.len() + 4, &whole).unwrap_err().to_string().contains("cut"));
        assert!(floats_of(&key, 0, b"").unwrap_err().to_string().contains("no file"));
        assert_eq!(key.to_string().len(), 64);
    }
}
