// Random glTF files as other programs may write them: trees of nodes with transforms or matrices, meshes that several nodes
// show, morph targets, skins, every interpolation, normalized and sparse numbers, gaps between them. three.js says where
// their vertices are at each key: check.mjs compares.
export function makeRandom(seed) {
  let state = seed;
  const random = () => { // Park and Miller's generator
    state = state * 48271 % 2147483647;
    return state / 2147483647;
  };
  const below = n => Math.floor(random() * n);
  const between = (a, b) => a + (b - a) * random();
  const list = (n, make) => Array.from({length: n}, (_, i) => make(i));
  const parts = [], bufferViews = [], accessors = [];
  let size = 0;
  const addView = (bytes, more = {}) => {
    parts.push(Buffer.from(bytes), Buffer.alloc((4 - bytes.length % 4) % 4));
    bufferViews.push({buffer: 0, byteOffset: size, byteLength: bytes.length, ...more});
    size += bytes.length + (4 - bytes.length % 4) % 4;
    return bufferViews.length - 1;
  };
  const bytesOf = array => new Uint8Array(array.buffer);
  const floats = (values, type) => {
    const width = {SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4, MAT4: 16}[type];
    const bufferView = addView(bytesOf(Float32Array.from(values)));
    const accessor = {bufferView, componentType: 5126, count: values.length / width, type};
    if (type === 'VEC3') {
      const column = k => Array.from(Float32Array.from(values)).filter((_, i) => i % 3 === k);
      accessor.min = [0, 1, 2].map(k => Math.min(...column(k)));
      accessor.max = [0, 1, 2].map(k => Math.max(...column(k)));
    }
    if (type === 'SCALAR') {
      accessor.min = [Math.fround(Math.min(...values))];
      accessor.max = [Math.fround(Math.max(...values))];
    }
    return accessors.push(accessor) - 1;
  };
  const quaternion = () => {
    const q = list(4, () => between(-1, 1));
    const length = Math.hypot(...q) || 1;
    return q.map(x => x / length);
  };
  const vectors = n => list(3 * n, () => between(-1, 1));

  const nodeCount = 6, jointCount = 3;
  const meshes = list(3, m => {
    const targetCount = m === 0 ? 0 : 1 + below(4);
    const primitives = list(1 + below(2), () => {
      const count = 4 + below(8);
      const attributes = {POSITION: floats(vectors(count), 'VEC3')};
      if (m === 2) { // for a skin
        attributes.JOINTS_0 = accessors.push({bufferView: addView(Uint8Array.from(list(4 * count, () => below(jointCount)))),
          componentType: 5121, count, type: 'VEC4'}) - 1;
        const weights = list(count, () => {
          const parts = list(3, () => below(85));
          return [...parts, 255 - parts[0] - parts[1] - parts[2]];
        }).flat();
        attributes.WEIGHTS_0 = accessors.push({bufferView: addView(Uint8Array.from(weights)), componentType: 5121, count,
          type: 'VEC4', normalized: true}) - 1;
      }
      const corners = list(3 * (2 + below(5)), () => below(count));
      const indices = accessors.push({bufferView: addView(bytesOf(Uint16Array.from(corners))), componentType: 5123,
        count: corners.length, type: 'SCALAR'}) - 1;
      const primitive = {attributes, indices};
      if (targetCount) primitive.targets = list(targetCount, t => {
        if (t % 2 === 0) return {POSITION: floats(vectors(count), 'VEC3')};
        const at = [0, 1 + below(count - 1)];
        return {POSITION: accessors.push({componentType: 5126, count, type: 'VEC3', min: [-1, -1, -1], max: [1, 1, 1],
          sparse: {count: 2, indices: {bufferView: addView(bytesOf(Uint16Array.from(at))), componentType: 5123},
            values: {bufferView: addView(bytesOf(Float32Array.from(vectors(2))))}}}) - 1};
      });
      return primitive;
    });
    return {primitives, ...(targetCount && m === 1 ? {weights: list(targetCount, () => between(0, 1))} : {})};
  });
  const nodes = list(nodeCount, i => {
    const node = {name: `node_${i}`};
    if (i > 0 && i % 3 === 0 && random() < 0.5) {
      const s = between(0.5, 2);
      node.matrix = [0, s, 0, 0, -s, 0, 0, 0, 0, 0, s, 0, between(-1, 1), between(-1, 1), 0, 1];
    } else {
      node.translation = vectors(1);
      node.rotation = quaternion();
      const s = between(0.5, 2);
      node.scale = [s, s, s];
    }
    node.mesh = i % 2;
    return node;
  });
  for (let i = 1; i < nodeCount; i++) (nodes[below(i)].children ??= []).push(i);
  const joints = list(jointCount, j => nodes.push({name: `joint_${j}`, translation: vectors(1), rotation: quaternion()}) - 1);
  (nodes[0].children ??= []).push(joints[0]);
  nodes[joints[0]].children = joints.slice(1);
  const skinned = nodes.push({name: 'skinned', mesh: 2, skin: 0}) - 1;
  const inverse = list(jointCount, () => {
    const s = between(0.5, 1.5);
    return [s, 0, 0, 0, 0, s, 0, 0, 0, 0, s, 0, between(-1, 1), between(-1, 1), between(-1, 1), 1];
  }).flat();
  const skins = [{joints, inverseBindMatrices: floats(inverse, 'MAT4')}];

  const keyCount = 4;
  const inputs = list(2, k => floats(list(keyCount, i => 0.25 * k + i * (0.5 + 0.25 * k)), 'SCALAR'));
  const samplers = [], channels = [];
  nodes.forEach((node, i) => {
    const targets = node.mesh === undefined ? 0 : meshes[node.mesh].primitives[0].targets?.length ?? 0;
    for (const path of ['translation', 'rotation', 'scale', 'weights']) {
      // three.js finds what weights drive by names below the node, so these must lead to one mesh.
      const isClear = !node.children && (node.mesh === 2 || meshes[node.mesh ?? 0].primitives.length === 1);
      if (path === 'weights' && !isClear) continue;
      if (random() < 0.4 || (node.matrix && path !== 'weights') || (path === 'weights' && !targets)) continue;
      const interpolation = ['LINEAR', 'STEP', 'CUBICSPLINE'][below(3)];
      const values = keyCount * (interpolation === 'CUBICSPLINE' ? 3 : 1);
      const data = {translation: () => vectors(1), rotation: quaternion, weights: () => list(targets, () => between(0, 1)),
        scale: () => { const s = between(0.5, 2); return [s, s, s]; }}[path];
      const type = {translation: 'VEC3', rotation: 'VEC4', scale: 'VEC3', weights: 'SCALAR'}[path];
      samplers.push({input: inputs[below(2)], output: floats(list(values, data).flat(), type), interpolation});
      channels.push({sampler: samplers.length - 1, target: {node: i, path}});
    }
  });
  const bytes = Buffer.concat(parts);
  return {asset: {version: '2.0'}, scene: 0, scenes: [{nodes: [0, skinned]}], nodes, meshes, skins, accessors, bufferViews,
    animations: [{samplers, channels}],
    buffers: [{byteLength: bytes.length, uri: 'data:application/octet-stream;base64,' + bytes.toString('base64')}]};
}
