// The peer "three.js SSRPass": three.js with the SSRPass of its WebGLRenderer. A peer is a file that exports its title,
// its npm package, its settings, and `render`, which draws a scene with chosen settings, or without reflections for
// null.

import * as THREE from 'three';
import { EffectComposer } from 'three/addons/postprocessing/EffectComposer.js';
import { SSRPass } from 'three/addons/postprocessing/SSRPass.js';
import { OutputPass } from 'three/addons/postprocessing/OutputPass.js';
import { cameraOf, meshesOf } from './three-scene.mjs';

export const title = 'three.js SSRPass';
export const npm = 'three';

// The values that the search tries for each setting; the first value is the default.
export const settings = {
    opacity: [0.5, 1],
    distanceAttenuation: [true, false],
    fresnel: [true, false],
    blur: [true, false],
    maxDistance: [180, 10, 20, 40],
    thickness: [0.018, 0.005, 0.05, 0.1, 0.3],
    infiniteThick: [false, true],
    bouncing: [false, true],
    logarithmicDepthBuffer: [false, true],
};

export async function render(canvas, scene, chosen) {
    const { logarithmicDepthBuffer = false, ...rest } = chosen ?? {};
    const renderer = new THREE.WebGLRenderer({ canvas, antialias: false, preserveDrawingBuffer: true, logarithmicDepthBuffer });
    renderer.setPixelRatio(1);
    renderer.setSize(scene.width, scene.height, false);
    renderer.toneMapping = THREE.NoToneMapping;
    const camera = cameraOf(THREE, scene), world = new THREE.Scene();
    const meshes = meshesOf(THREE, scene, THREE.MeshBasicMaterial, THREE.MeshStandardMaterial);
    world.add(...meshes.values());
    if (chosen === null) {
        renderer.render(world, camera);
        return;
    }
    const composer = new EffectComposer(renderer);
    composer.setPixelRatio(1);
    composer.setSize(scene.width, scene.height);
    const pass = new SSRPass({
        renderer, scene: world, camera, width: scene.width, height: scene.height, selects: [meshes.get('floor')],
    });
    for (const [name, value] of Object.entries(rest))
        pass[name] = value;
    composer.addPass(pass);
    composer.addPass(new OutputPass());
    // With `bouncing`, a frame reads the frame before it, so that several frames are drawn.
    for (let frame = 0; frame < 3; ++frame)
        composer.render();
}
