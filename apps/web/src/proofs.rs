use anyhow::anyhow;
use serde_json::{Map, json};
use umbrage_page::{Look, Studio};

/// Scenes (address, samples, bounces) with several kinds of lights, masks, textures and mirrors: small, since browsers
/// render them.
const CASES: &[(&str, u32, u32)] = &[
    ("demo:marbles?triangles=20000", 1, 0),
    ("demo:hall?triangles=20000", 1, 0),
    ("demo:forest?triangles=20000", 4, 0),
    ("demo:gears?triangles=20000", 1, 0),
    ("demo:glass?triangles=5000", 4, 2),
];

/// Prints a list of `{address, look, proof}`; `look` is the input of the page's engine.
pub(crate) fn print() -> anyhow::Result<()> {
    let mut cases = Vec::new();
    for &(address, samples, bounces) in CASES {
        let look = json!({ "width": 320, "height": 180, "seconds": 0.7, "samples": samples, "bounces": bounces });
        let mut studio = Studio::default();
        studio.open_demo(address).map_err(|why| anyhow!(why))?;
        let look_at = serde_json::from_value::<Look>(look.clone())?;
        pollster::block_on(studio.render(&look_at)).map_err(|why| anyhow!(why))?;
        let case = [("address", address.into()), ("look", look), ("proof", serde_json::to_value(studio.proof())?)];
        cases.push(Map::from_iter(case.map(|(name, value)| (name.to_owned(), value))));
    }
    println!("{}", serde_json::to_string_pretty(&cases)?);
    Ok(())
}
