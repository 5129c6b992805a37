//! Every shader passes naga, and shared structs have the same offsets in Rust and WGSL.

use himmel::parts::gpu::layout::{Layout, SHARED, SHARED_ELSEWHERE};
use himmel::parts::gpu::shader;
use naga::valid::{Capabilities, ValidationFlags, Validator};

fn parse(root: &str) -> naga::Module {
    let text = shader::module(root).expect("the files join");
    naga::front::wgsl::parse_str(&text).unwrap_or_else(|error| panic!("{root}: {}", error.emit_to_string(&text)))
}

/// No capability beyond those that WebGPU guarantees. `pack2x16float` and its inverse are in its core; naga counts them apart because
/// old GLES lacks them.
#[test]
fn every_shader_is_valid_webgpu() {
    for root in shader::ROOTS {
        let module = parse(root);
        Validator::new(ValidationFlags::all(), Capabilities::SHADER_FLOAT16_IN_FLOAT32)
            .validate(&module)
            .unwrap_or_else(|error| panic!("{root}: {error:?}"));
        assert!(!module.entry_points.is_empty(), "{root}");
    }
}

#[test]
fn every_file_is_used_and_every_file_on_disk_is_known() {
    let all: String = shader::ROOTS.iter().map(|root| shader::module(root).expect("the files join")).collect();
    for (path, _) in shader::FILES {
        assert!(all.contains(&format!("// ---- {path}\n")), "{path} is included by nobody");
    }
    let source = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/himmel-gpu/src");
    let mut folders = vec![source.clone()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("a folder").flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|ending| ending == "wgsl") {
                let name = path.strip_prefix(&source).expect("inside").to_string_lossy().replace('\\', "/");
                assert!(shader::embedded(&name).is_some(), "{name} is not in shader::FILES");
            }
        }
    }
}

/// The fields of a struct of that name, as naga lays them out.
fn wgsl_layout(module: &naga::Module, name: &str) -> Option<(usize, Vec<(String, usize)>)> {
    module.types.iter().find_map(|(_, ty)| match &ty.inner {
        naga::TypeInner::Struct { members, span } if ty.name.as_deref() == Some(name) => {
            let fields = members.iter().map(|m| (m.name.clone().unwrap_or_default(), m.offset as usize)).collect();
            Some((*span as usize, fields))
        }
        _ => None,
    })
}

fn difference(layout: &Layout, module: &naga::Module) -> Option<String> {
    let Some((size, fields)) = wgsl_layout(module, layout.name) else {
        return Some(format!("{} is not in WGSL", layout.name));
    };
    let rust: Vec<(String, usize)> =
        layout.fields.iter().map(|(name, offset)| ((*name).to_string(), *offset)).collect();
    (size != layout.size || fields != rust)
        .then(|| format!("{}: Rust {} {rust:?}, WGSL {size} {fields:?}", layout.name, layout.size))
}

#[test]
fn shared_structs_have_the_same_offsets() {
    let module = parse("sky.wgsl");
    for layout in SHARED {
        assert_eq!(difference(layout, &module), None);
    }
    for (root, layout) in SHARED_ELSEWHERE {
        assert_eq!(difference(layout, &parse(root)), None, "{root}");
    }
}

#[test]
fn a_moved_field_is_noticed() {
    let text = shader::module("sky.wgsl").expect("the files join").replacen(
        "bottom_radius_m: f32,\n",
        "moved: f32,\n    bottom_radius_m: f32,\n",
        1,
    );
    let module = naga::front::wgsl::parse_str(&text).expect("still WGSL");
    assert!(SHARED.iter().any(|layout| difference(layout, &module).is_some()));
}
