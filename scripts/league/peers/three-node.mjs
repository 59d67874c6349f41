// The peer "three.js SSRNode": three.js with the SSRNode of its WebGPURenderer, which runs on WebGL here.
// three-pass.mjs explains what a peer exports.

import * as THREE from 'three/webgpu';
import { add, colorToDirection, directionToColor, metalness, mrt, normalView, output, pass, roughness, sample, vec2 } from 'three/tsl';
import { ssr } from 'three/addons/tsl/display/SSRNode.js';
import { cameraOf, meshesOf } from './three-scene.mjs';

export const title = 'three.js SSRNode';
export const npm = 'three';

export const settings = {
    stochastic: [false, true],
    quality: [0.5, 1],
    maxDistance: [1, 5, 10, 20, 40],
    thickness: [0.1, 0.02, 0.05, 0.3, 1],
    intensity: [1, 2],
    screenEdgeFade: [0.2, 0],
    binaryRefine: [false, true],
    blurQuality: [2, 1],
    mirrorBias: [0, 1],
    stepExponent: [2, 1],
};
// These settings are arguments of `ssr`; the others are set on the node that `ssr` returns.
const AT_BIRTH = ['stochastic', 'binaryRefine'];
const NUMBERS = ['blurQuality', 'stepExponent'];

export async function render(canvas, scene, chosen) {
    const renderer = new THREE.WebGPURenderer({ canvas, antialias: false, forceWebGL: true });
    renderer.setPixelRatio(1);
    renderer.setSize(scene.width, scene.height, false);
    renderer.toneMapping = THREE.NoToneMapping;
    await renderer.init();
    const camera = cameraOf(THREE, scene), world = new THREE.Scene();
    world.add(...meshesOf(THREE, scene, THREE.MeshBasicNodeMaterial, THREE.MeshStandardNodeMaterial).values());
    if (chosen === null) {
        renderer.render(world, camera);
        return;
    }
    const shown = pass(world, camera, { minFilter: THREE.NearestFilter, magFilter: THREE.NearestFilter });
    shown.setMRT(mrt({ output, normal: directionToColor(normalView), material: vec2(metalness, roughness) }));
    const color = shown.getTextureNode('output'), normals = shown.getTextureNode('normal');
    const material = shown.getTextureNode('material');
    const normal = sample((uv) => colorToDirection(normals.sample(uv)));
    const options = { metalnessNode: material.r, roughnessNode: material.g, camera };
    for (const name of AT_BIRTH)
        if (name in chosen)
            options[name] = chosen[name];
    const node = ssr(color, shown.getTextureNode('depth'), normal, options);
    for (const [name, value] of Object.entries(chosen)) {
        if (NUMBERS.includes(name))
            node[name] = value;
        else if (!AT_BIRTH.includes(name))
            node[name].value = value;
    }
    const pipeline = new THREE.RenderPipeline(renderer);
    pipeline.outputNode = add(color, node);
    for (let frame = 0; frame < 3; ++frame)
        pipeline.render();
}
