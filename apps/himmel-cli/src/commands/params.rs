//! `himmel params`

use himmel::Scene;
use himmel::params::Value;

use crate::{Failure, out};

/// Arguments of `himmel params`.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  himmel params\n  himmel params air\n  himmel params --json")]
pub struct Args {
    /// Only parameters whose name contains this.
    filter: Option<String>,
    /// Print them as JSON.
    #[arg(long)]
    json: bool,
}

/// Runs it.
pub fn run(args: &Args) -> Result<(), Failure> {
    let filter = args.filter.as_deref().unwrap_or("");
    let all: Vec<_> = Scene::describe().into_iter().filter(|info| info.key().contains(filter)).collect();
    if all.is_empty() {
        return Err(Failure::usage(format!("no parameter contains \"{filter}\"; `himmel params` lists them all")));
    }
    if args.json {
        let rows: Vec<_> = all
            .iter()
            .map(|info| {
                let default = match &info.default {
                    Value::Number(number) => serde_json::json!(number),
                    Value::Flag(flag) => serde_json::json!(flag),
                    Value::Text(text) => serde_json::json!(text),
                    Value::Unset => serde_json::Value::Null,
                };
                serde_json::json!({
                    "name": info.key(), "unit": info.unit, "accepts": info.accepts(), "default": default, "sentence": info.sentence,
                })
            })
            .collect();
        out!("{}", serde_json::to_string_pretty(&rows).map_err(|e| Failure::failed(e.to_string()))?);
        return Ok(());
    }
    let mut table = "";
    for info in all {
        if info.table != table {
            out!("{}[{}]", if table.is_empty() { "" } else { "\n" }, info.table);
            table = info.table;
        }
        let unit = if info.unit.is_empty() { String::new() } else { format!(" {}", info.unit) };
        out!("{} = {}{unit}   ({})", info.key(), info.default, info.accepts());
        out!("    {}", info.sentence);
    }
    Ok(())
}
