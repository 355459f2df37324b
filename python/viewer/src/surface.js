// A body as three.js draws it: vertices, normals, colors, and the edges of its triangles.
import * as THREE from 'three';
import { mapValue } from '../../../web/src/color.ts';
import { computeNormals, findEdges, splitSharpEdges } from '../../../web/src/geometry.ts';

// Numbers of drawn vertices: those of the body, or of its vertices split at sharp edges. A cloth has no sharp edges.
function splitVertices(body) {
  if (body.kind === 'cloth')
    return { index: body.triangles, source: Uint32Array.from({ length: body.vertexCount }, (_, i) => i) };
  const positions = Float64Array.from({ length: 3 * body.vertexCount }, (_, i) => body.get(0, Math.floor(i / 3), i % 3));
  return splitSharpEdges(positions, body.triangles);
}

// The back is a little darker, so that folds tell their sides apart.
function darkenBack(shader) {
  shader.fragmentShader = shader.fragmentShader.replace(
    '#include <color_fragment>', '#include <color_fragment>\nif (!gl_FrontFacing) diffuseColor.rgb *= 0.72;');
}

export class Surface {
  constructor(body, color, scale) {
    this.body = body;
    this.scale = scale;
    const { index, source } = splitVertices(body);
    this.index = index;
    this.source = source;
    const geometry = new THREE.BufferGeometry();
    geometry.setIndex(new THREE.BufferAttribute(index, 1));
    for (const name of ['position', 'normal', ...(body.values ? ['color'] : [])])
      geometry.setAttribute(name, new THREE.BufferAttribute(new Float32Array(3 * source.length), 3));
    const material = new THREE.MeshStandardMaterial({
      color: body.values ? 0xffffff : new THREE.Color(...color), vertexColors: Boolean(body.values), side: THREE.DoubleSide,
      roughness: 0.85, metalness: 0, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1,
    });
    material.onBeforeCompile = darkenBack;
    this.mesh = new THREE.Mesh(geometry, material);
    this.mesh.castShadow = this.mesh.receiveShadow = true;
    this.mesh.frustumCulled = false;
    this.edges = null;
    this.frame = -1;
  }

  setEdges(isShown) {
    if (isShown && !this.edges) {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute('position', this.mesh.geometry.getAttribute('position'));
      geometry.setIndex(new THREE.BufferAttribute(findEdges(this.index, this.source.length), 1));
      this.edges = new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color: 0x1b2430, transparent: true, opacity: 0.55 }));
      this.edges.frustumCulled = false;
      this.mesh.add(this.edges);
    }
    if (this.edges) this.edges.visible = isShown;
  }

  setFrame(frame) {
    this.mesh.visible = this.body.isPresent(frame);
    if (this.frame === frame || (this.frame >= 0 && this.body.frameCount === 1)) return;
    this.frame = frame;
    const { body, source } = this;
    const positions = this.mesh.geometry.getAttribute('position'), colors = this.mesh.geometry.getAttribute('color');
    for (let i = 0; i < source.length; i++)
      for (let axis = 0; axis < 3; axis++) positions.array[3 * i + axis] = body.get(frame, source[i], axis);
    positions.needsUpdate = true;
    const normals = this.mesh.geometry.getAttribute('normal');
    computeNormals(positions.array, this.index, normals.array);
    normals.needsUpdate = true;
    if (!colors) return;
    for (let i = 0; i < source.length; i++) colors.array.set(mapValue(this.scale.map, body.getValue(frame, source[i])), 3 * i);
    colors.needsUpdate = true;
  }

  // Lets go of what a renderer holds of it; another one takes it up again.
  release() {
    for (const part of [this.mesh, this.edges]) {
      part?.geometry.dispose();
      part?.material.dispose();
    }
  }
}
