// Arrays from base64 of little-endian bytes.

function bytesOf(text) {
  const raw = atob(text);
  const bytes = new Uint8Array(raw.length);
  for (let k = 0; k < raw.length; k++) bytes[k] = raw.charCodeAt(k);
  return bytes.buffer;
}

export function int16(text) {
  return new Int16Array(bytesOf(text));
}

export function uint16(text) {
  return new Uint16Array(bytesOf(text));
}

export function uint32(text) {
  return new Uint32Array(bytesOf(text));
}

export function float32(text) {
  return new Float32Array(bytesOf(text));
}

export function float64(text) {
  return new Float64Array(bytesOf(text));
}
