//! Tokens of WGSL. naga gives a name the span of its declaration, so that operands and arguments are found in the text of
//! the expression that they belong to.

use std::ops::Range;

/// Operators of several characters, the longest first.
const LONG_SIGNS: [&str; 21] = [
    "<<=", ">>=", "++", "--", "&&", "||", "==", "!=", "<=", ">=", "<<", ">>", "+=", "-=", "*=", "/=", "%=", "&=", "|=",
    "^=", "->",
];

/// Signs that end in `=` and assign nothing.
const COMPARISONS: [&str; 4] = ["==", "!=", "<=", ">="];

/// A token.
pub struct Token {
    /// Its bytes.
    pub range: Range<usize>,
    /// Number of parentheses, brackets and braces around it.
    pub depth: usize,
    /// True if a value may end here, so that an operator behind it has two operands.
    ends_value: bool,
}

/// Splits a text into tokens, without comments.
pub fn split_tokens(text: &str) -> Vec<Token> {
    let mut tokens = Vec::new();
    let (mut at, mut depth) = (0, 0usize);
    while let Some(first) = text[at..].chars().next() {
        let rest = &text[at..];
        let is_word = |c: char| c.is_alphanumeric() || c == '_';
        let length = if let Some(comment) = rest.strip_prefix("//") {
            at += 2 + comment.find('\n').unwrap_or(comment.len());
            continue;
        } else if rest.starts_with("/*") {
            at += block_comment_length(rest);
            continue;
        } else if is_word(first) {
            let is_number = first.is_ascii_digit();
            let ends = |c: char| !(is_word(c) || is_number && c == '.');
            let length = rest.find(ends).unwrap_or(rest.len());
            // The exponent of a number may have a sign.
            let exponent = rest[length..].strip_prefix(['-', '+']);
            match exponent.filter(|_| is_number && rest[..length].ends_with('e')) {
                Some(digits) => length + 1 + digits.find(ends).unwrap_or(digits.len()),
                None => length,
            }
        } else {
            let long = LONG_SIGNS.iter().find(|sign| rest.starts_with(**sign));
            long.map_or(first.len_utf8(), |sign| sign.len())
        };
        if matches!(first, ')' | ']' | '}') {
            depth = depth.saturating_sub(1);
        }
        if !first.is_whitespace() {
            tokens.push(Token {
                range: at..at + length,
                depth,
                ends_value: is_word(first) || matches!(first, ')' | ']'),
            });
        }
        if matches!(first, '(' | '[' | '{') {
            depth += 1;
        }
        at += length;
    }
    tokens
}

/// Returns the bytes of the block comment with which a text begins; block comments nest.
fn block_comment_length(text: &str) -> usize {
    let (mut at, mut depth) = (0, 0);
    while let Some(first) = text[at..].chars().next() {
        let (step, change) = match text.get(at..at + 2) {
            Some("/*") => (2, 1),
            Some("*/") => (2, -1),
            _ => (first.len_utf8(), 0),
        };
        (at, depth) = (at + step, depth + change);
        if depth == 0 {
            return at;
        }
    }
    text.len()
}

/// Returns the bytes of the operator of an expression `left sign right`, or of `left sign= right`.
pub fn find_operator(text: &str, sign: &str) -> Option<Range<usize>> {
    let tokens = split_tokens(text);
    let assigned = tokens.iter().find(|token| {
        let token = &text[token.range.clone()];
        token.strip_suffix('=') == Some(sign) && !COMPARISONS.contains(&token)
    });
    if let Some(token) = assigned {
        return Some(token.range.start..token.range.start + sign.len());
    }
    let operators = tokens.windows(2).rev();
    let mut operators = operators.filter(|pair| pair[0].ends_value && pair[1].depth == 0);
    let found = operators.find(|pair| &text[pair[1].range.clone()] == sign)?;
    Some(found[1].range.clone())
}

/// Returns the bytes of the arguments of a call, `name(a, b)`.
pub fn find_arguments(text: &str) -> Vec<Range<usize>> {
    let tokens = split_tokens(text);
    let separators = tokens.iter().filter(|token| match &text[token.range.clone()] {
        "(" | ")" => token.depth == 0,
        sign => sign == "," && token.depth == 1,
    });
    let separators: Vec<&Token> = separators.collect();
    let between = separators.windows(2).map(|pair| pair[0].range.end..pair[1].range.start);
    between.filter_map(|range| trim_range(text, range)).collect()
}

/// Returns the bytes of the index at the end of `base[index]`.
pub fn find_index(text: &str) -> Option<Range<usize>> {
    let tokens = split_tokens(text);
    let close = tokens.last().filter(|token| &text[token.range.clone()] == "]")?;
    let mut opens = tokens.iter().rev().filter(|token| token.depth == close.depth);
    let open = opens.find(|token| &text[token.range.clone()] == "[")?;
    trim_range(text, open.range.end..close.range.start)
}

/// Returns the bytes of the condition of `if condition {`.
pub fn find_condition(text: &str) -> Option<Range<usize>> {
    let tokens = split_tokens(text);
    let start = tokens.iter().find(|token| &text[token.range.clone()] == "if")?;
    let mut after = tokens.iter().filter(|token| token.range.start > start.range.start);
    let open = after.find(|token| token.depth == 0 && &text[token.range.clone()] == "{")?;
    trim_range(text, start.range.end..open.range.start)
}

/// Returns a range without white space at its ends; none if nothing is left.
pub fn trim_range(text: &str, range: Range<usize>) -> Option<Range<usize>> {
    let part = text.get(range.clone())?;
    let start = range.start + part.len() - part.trim_start().len();
    let end = start + part.trim().len();
    (start < end).then_some(start..end)
}

/// Returns the bytes of the parentheses with which a text begins; 0 if it does not.
pub fn arguments_length(text: &str) -> usize {
    let tokens = split_tokens(text);
    let opens = text.starts_with('(');
    let close = tokens.iter().skip(1).find(|token| token.depth == 0);
    close.filter(|_| opens).map_or(0, |token| token.range.end)
}

#[cfg(test)]
mod tests {
    use super::{find_arguments, find_condition, find_index, find_operator};

    #[test]
    fn operators_are_those_between_two_operands() {
        let at = |text: &str, sign| find_operator(text, sign).map(|range| range.start);
        assert_eq!(at("a - b - -c", "-"), Some(6));
        assert_eq!(at("(a - b) * 1e-6 // - c", "-"), None);
        assert_eq!(at("x[a + 1] += b + c", "+"), Some(9));
        assert_eq!(at("a <= b", "<"), None);
        assert_eq!(at("-a", "-"), None);
        assert_eq!(at("a++", "+"), None);
        assert_eq!(at("a /* + /* é */ - */ + b", "+"), Some(21));
    }

    #[test]
    fn parts_of_calls_indices_and_conditions_are_found() {
        let text = "f(a, g(b, c), d[e, 1])";
        let found: Vec<&str> = find_arguments(text).into_iter().map(|range| &text[range]).collect();
        assert_eq!(found, ["a", "g(b, c)", "d[e, 1]"]);
        let text = "a[b].c[d[e] + 1]";
        assert_eq!(find_index(text).map(|range| &text[range]), Some("d[e] + 1"));
        assert_eq!(find_index("a[b].c"), None);
        let text = "if a || (b) { c(); }";
        assert_eq!(find_condition(text).map(|range| &text[range]), Some("a || (b)"));
    }
}
