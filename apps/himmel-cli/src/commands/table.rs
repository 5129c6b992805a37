//! Tables of questions: CSV, or JSON lists of objects.

use std::io::Read;
use std::path::Path;

use crate::Failure;

/// The bytes of a table as CSV; `-` is the standard input. A JSON list of objects becomes CSV.
pub fn read_table(input: &Path) -> Result<Vec<u8>, Failure> {
    let bytes = read(input)?;
    match bytes.iter().find(|byte| !byte.is_ascii_whitespace()) {
        Some(b'[' | b'{') => csv_from_json(&bytes).map_err(|e| Failure::failed(format!("{}: {e}", input.display()))),
        _ => Ok(bytes),
    }
}

/// A list of flat objects (or one object) as a table: the columns are all keys, in the order of their first appearance.
fn csv_from_json(bytes: &[u8]) -> Result<Vec<u8>, String> {
    let rows = match serde_json::from_slice(bytes).map_err(|e| e.to_string())? {
        serde_json::Value::Array(rows) => rows,
        row => vec![row],
    };
    let mut header: Vec<String> = Vec::new();
    for (index, row) in rows.iter().enumerate() {
        let object = row.as_object().ok_or_else(|| format!("entry {} is no object", index + 1))?;
        for key in object.keys().filter(|key| !header.contains(key)).cloned().collect::<Vec<_>>() {
            header.push(key);
        }
    }
    let field = |row: &serde_json::Value, key: &str| match row.get(key) {
        None | Some(serde_json::Value::Null) => String::new(),
        Some(serde_json::Value::String(text)) => text.clone(),
        Some(other) => other.to_string(),
    };
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record(&header).map_err(|e| e.to_string())?;
    for row in &rows {
        table.write_record(header.iter().map(|key| field(row, key))).map_err(|e| e.to_string())?;
    }
    table.into_inner().map_err(|e| e.to_string())
}

fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    let mut bytes = Vec::new();
    let result = if path == Path::new("-") {
        std::io::stdin().read_to_end(&mut bytes).map(drop)
    } else {
        std::fs::read(path).map(|content| bytes = content)
    };
    result.map(|()| bytes).map_err(|e| Failure::failed(format!("cannot read {}: {e}", path.display())))
}
