// Makes the camera and the meshes of a scene for three.js, for both of its renderers. THREE is the module of the
// renderer.

// The camera of a scene; `fovY` is in radians.
export function cameraOf(THREE, scene) {
    const camera = new THREE.PerspectiveCamera(scene.fovY * 180 / Math.PI, scene.width / scene.height, scene.near, scene.far);
    camera.position.set(...scene.eye);
    camera.lookAt(...scene.lookAt);
    camera.updateMatrixWorld();
    return camera;
}

// The meshes, one for each material, in a map from the name of the material. The floor alone is lit, and is a metal.
export function meshesOf(THREE, scene, Unlit, Lit) {
    const meshes = new Map();
    for (const name of new Set(scene.quads.map((q) => q.material))) {
        const own = scene.quads.filter((q) => q.material === name);
        const geometry = new THREE.BufferGeometry();
        const floats = (list) => new THREE.Float32BufferAttribute(list.flat(2), 3);
        geometry.setAttribute('position', floats(own.map((q) => q.corners)));
        geometry.setAttribute('normal', floats(own.map((q) => [q.normal, q.normal, q.normal, q.normal])));
        geometry.setIndex(own.flatMap((_, k) => [0, 1, 2, 0, 2, 3].map((i) => 4 * k + i)));
        const [r, g, b] = own[0].color;
        const color = new THREE.Color(`rgb(${r}, ${g}, ${b})`);
        const material = name === 'floor'
            ? new Lit({ color: 0xffffff, metalness: 1, roughness: scene.roughness })
            : new Unlit({ color });
        meshes.set(name, new THREE.Mesh(geometry, material));
    }
    return meshes;
}
