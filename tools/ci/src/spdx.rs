/// Whether an SPDX licence expression can be met by licences of an allow-list.
///
/// `/` stands for `OR`, as in older manifests; `A WITH B` is one licence and must be allowed as such.
///
/// # Errors
/// Says what is wrong with an expression.
pub(crate) fn is_allowed(expression: &str, allowed: &[String]) -> Result<bool, String> {
    let spaced = expression.replace('(', " ( ").replace(')', " ) ").replace('/', " OR ");
    let words: Vec<&str> = spaced.split_whitespace().collect();
    let mut rest = words.as_slice();
    let met = either(&mut rest, allowed)?;
    match rest {
        [] => Ok(met),
        [word, ..] => Err(format!("`{word}` is out of place in `{expression}`")),
    }
}

/// Alternatives of [`both`]; `OR` binds less than `AND`.
fn either(words: &mut &[&str], allowed: &[String]) -> Result<bool, String> {
    let mut met = both(words, allowed)?;
    while let ["OR", rest @ ..] = *words {
        *words = rest;
        met |= both(words, allowed)?;
    }
    Ok(met)
}

fn both(words: &mut &[&str], allowed: &[String]) -> Result<bool, String> {
    let mut met = single(words, allowed)?;
    while let ["AND", rest @ ..] = *words {
        *words = rest;
        met &= single(words, allowed)?;
    }
    Ok(met)
}

fn single(words: &mut &[&str], allowed: &[String]) -> Result<bool, String> {
    let is_listed = |licence: &str| allowed.iter().any(|allowed| allowed == licence);
    match *words {
        ["(", rest @ ..] => {
            *words = rest;
            let met = either(words, allowed)?;
            let [")", rest @ ..] = *words else { return Err("a bracket is not closed".to_owned()) };
            *words = rest;
            Ok(met)
        }
        [licence, "WITH", exception, rest @ ..] => {
            *words = rest;
            Ok(is_listed(&format!("{licence} WITH {exception}")))
        }
        ["OR" | "AND" | "WITH" | ")", ..] | [] => Err("a licence is missing".to_owned()),
        [licence, rest @ ..] => {
            *words = rest;
            Ok(is_listed(licence))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn expressions_are_evaluated() {
        let allowed = ["MIT", "Zlib", "Apache-2.0 WITH LLVM-exception"].map(str::to_owned);
        for (expression, met) in [
            ("MIT", true),
            ("GPL-3.0", false),
            ("GPL-3.0 OR MIT", true),
            ("MIT/GPL-3.0", true),
            ("MIT AND GPL-3.0", false),
            ("MIT OR GPL-3.0 AND LGPL-3.0", true),
            ("(MIT OR GPL-3.0) AND LGPL-3.0", false),
            ("(MIT OR GPL-3.0) AND (Zlib)", true),
            ("Apache-2.0 WITH LLVM-exception", true),
            ("Apache-2.0", false),
            ("MIT WITH LLVM-exception", false),
        ] {
            assert_eq!(is_allowed(expression, &allowed), Ok(met), "{expression}");
        }
        for wrong in ["", "OR", "MIT OR", "(MIT", "MIT)", "MIT Zlib", "MIT WITH", "()"] {
            assert!(is_allowed(wrong, &allowed).is_err(), "{wrong}");
        }
    }
}
