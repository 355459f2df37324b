// Reads the archives that Tulle writes: a ZIP file of .npy arrays, not compressed.
import fs from 'node:fs';

export function readArrays(path) {
  const bytes = fs.readFileSync(path);
  const arrays = {};
  for (let at = 0; bytes.readUInt32LE(at) === 0x04034b50;) {
    const size = bytes.readUInt32LE(at + 18);
    const nameSize = bytes.readUInt16LE(at + 26);
    const data = at + 30 + nameSize + bytes.readUInt16LE(at + 28);
    const name = bytes.toString('utf8', at + 30, at + 30 + nameSize).replace('.npy', '');
    const head = bytes.toString('latin1', data + 10, data + 10 + bytes.readUInt16LE(data + 8));
    const type = /'descr': '(.*?)'/.exec(head)[1];
    const shape = /'shape': \((.*?)\)/.exec(head)[1].split(',').filter(s => s.trim()).map(Number);
    const from = data + 10 + bytes.readUInt16LE(data + 8);
    const part = bytes.buffer.slice(bytes.byteOffset + from, bytes.byteOffset + data + size);
    const make = {'<f4': Float32Array, '<f8': Float64Array, '<i8': BigInt64Array}[type];
    arrays[name] = {shape, data: make ? new make(part) : part};
    at = data + size;
  }
  return arrays;
}
