// What the pages of records share: packed numbers, elements, formats.

const HALVES = Float32Array.from({ length: 65536 }, (_, bits) => from_half(bits));

// Inflates bytes (RFC 1951).
async function inflate(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// Undoes `fold_difference` of oracle/src/trace/packing.rs.
const unfold_difference = (low, high) => {
  const folded = low | (high << 8);
  return (folded >> 1) ^ -(folded & 1);
};

// Formats a power in watts with four significant digits, thousands apart.
const watts = (power) => {
  const rounded = Number(power.toPrecision(4));
  const [whole, part] = String(rounded).split(".");
  const text = Math.abs(rounded) >= 1e9 || String(rounded).includes("e") ? number(rounded) : whole.replace(/\B(?=(\d{3})+$)/g, "\u202f") + (part ? `.${part}` : "");
  return `${text.replace("-", "−")} W`;
};

const percent = (share) => `${Number((100 * share).toPrecision(3))} %`.replace("-", "−");

// Makes an element, of SVG if a name space is given.
function make(tag, attributes = {}, children = []) {
  const own = tag.startsWith("svg:") ? document.createElementNS("http://www.w3.org/2000/svg", tag.slice(4)) : document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) own.setAttribute(name, value);
  own.append(...children);
  return own;
}

// Returns `part` over `whole`; 0 of nothing.
function share_of(part, whole) {
  return whole > 0 ? part / whole : 0;
}
