//! WGSL wants parentheses around shifts and bitwise operators beside others. naga does without, browsers do not.

use super::source::files_below;
use std::mem::take;

const SHIFTS: [&str; 2] = ["<<", ">>"];
const BITWISE: [&str; 3] = ["&", "|", "^"];
const ARITHMETIC: [&str; 5] = ["+", "-", "*", "/", "%"];
const RELATIONS: [&str; 6] = ["==", "!=", "<", "<=", ">", ">="];

/// Returns whether WGSL refuses these operators without parentheses between them.
fn mixes_operators(operators: &[&str]) -> bool {
    let shifts = operators.iter().filter(|sign| SHIFTS.contains(sign)).count();
    let bitwise: Vec<_> = operators.iter().filter(|sign| BITWISE.contains(sign)).collect();
    let relations = operators.iter().filter(|sign| RELATIONS.contains(sign)).count();
    if let Some(first) = bitwise.first() {
        return operators.iter().any(|sign| sign != *first);
    }
    // Each side of a relation may have one shift.
    shifts > 1 + relations || (shifts > 0 && operators.len() > shifts + relations)
}

/// Returns the line of the first expression of a shader that browsers refuse.
fn find_mixed_operators(text: &str) -> Option<&str> {
    // Operators so far, outside all parentheses and in each that is open.
    let mut open: Vec<Vec<&str>> = vec![Vec::new()];
    for line in text.lines() {
        let code = line.split("//").next().unwrap_or_default();
        for word in code.split_whitespace() {
            let known = [&SHIFTS[..], &BITWISE, &ARITHMETIC, &RELATIONS];
            if known.iter().any(|signs| signs.contains(&word)) {
                open.last_mut()?.push(word);
                continue;
            }
            let ends_expression = matches!(word, "&&" | "||" | "=" | "{" | "}" | "return") || word.ends_with('=');
            let signs = word.chars().chain(ends_expression.then_some(';'));
            for sign in signs {
                let ended = match sign {
                    ')' | ']' => open.pop()?,
                    ',' | ';' => take(open.last_mut()?),
                    _ => Vec::new(),
                };
                if mixes_operators(&ended) {
                    return Some(line);
                }
                if matches!(sign, '(' | '[') {
                    open.push(Vec::new());
                }
            }
        }
    }
    None
}

#[test]
fn shaders_parenthesise_what_browsers_want() {
    for refused in [
        "a << 8u | b;",
        "(1u >> (k % 6u) & 1u)",
        "x = a & b == 0u;",
        "f(a + b << 2u)",
    ] {
        assert!(find_mixed_operators(refused).is_some(), "{refused}");
    }
    for accepted in [
        "(a << 8u) | b;",
        "a & b & (c - 1u);",
        "if a >> 2u != 0u && b < c + d {",
        "a &= b - 1u;",
    ] {
        assert_eq!(find_mixed_operators(accepted), None);
    }
    let shaders = files_below("gpu/src/shaders", ".wgsl");
    assert!(!shaders.is_empty());
    for (file, text) in shaders {
        assert_eq!(find_mixed_operators(&text), None, "{file}");
    }
}
