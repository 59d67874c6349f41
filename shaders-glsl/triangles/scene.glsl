// The triangles of a scene as shaders read them. One buffer has the nodes of the tree, and the corners and attributes
// of triangles. A second one has materials and tables of images, and a third one the texels of all images. Filled in by
// src/passes/triangle_scene.rs, from the records of ground/src/scene/tree.rs.
//
// Each buffer is bound twice, as texels and as a storage block. GEOMETRY_TEXELS and IMAGE_TEXELS say how shaders read
// it: as texels wherever the device can address so many, since some devices read texels faster.

#ifndef TRIANGLES_SCENE_GLSL
#define TRIANGLES_SCENE_GLSL

#include "common/constants.glsl"

// The resources and constants of every program that traces rays against triangles, from this file and from those that
// colour hits.
#pragma group(TriangleResources, geometry_texels, geometry, table_texels, table, image_texels, images, triangles, scene, screen_color, screen_depth)
#pragma group(TriangleConstants, GEOMETRY_TEXELS, IMAGE_TEXELS, ASKS, LIGHTS, SCREEN_COLORS, WALK_ROOM)

layout(constant_id = 20) const bool GEOMETRY_TEXELS = true; // geometry is read as texels
layout(constant_id = 21) const bool IMAGE_TEXELS = true;    // images are read as texels
layout(constant_id = 23) const bool ASKS = true; // some material decides at each hit whether its surface is there
layout(constant_id = 26) const int WALK_ROOM = TREE_DEPTH; // groups of nodes that a walk has room for: as many as trees have levels

layout(binding = 20, rgba32ui) uniform readonly uimageBuffer geometry_texels;
layout(std430, binding = 21) readonly buffer GeometryWords {
    uvec4 words[];
} geometry;

layout(binding = 22, rgba32ui) uniform readonly uimageBuffer table_texels;
layout(std430, binding = 23) readonly buffer TableWords {
    uvec4 words[];
} table;

layout(binding = 24, r32ui) uniform readonly uimageBuffer image_texels;
layout(std430, binding = 25) readonly buffer ImageWords {
    uint words[];
} images;

// Where the parts of the triangles begin in the buffers, and where the camera is. Coordinates of triangles are measured
// from the tree's origin.
layout(std140, binding = 26) uniform TriangleBlock {
    vec3 eye;            // the camera's eye from the tree's origin, metres
    float extent;        // the greatest coordinate of a corner, metres
    int corners;         // where the corners begin among the vectors of geometry; nodes begin at 0
    int attributes;      // where the attributes begin
    int count;           // number of triangles
    int nodes;           // nodes of the tree; 0 for an empty tree
    int moving;          // the root of the tree of moving things; 0 for none
    float beside;        // how far a pixel's point may lie beside its surface: in metres for each metre from the eye, or in view
                         // units where rays of sight are parallel
} triangles;

// Geometry, Table and ImageWord load entry i of the three buffers.
uvec4 Geometry(int i) {
    return GEOMETRY_TEXELS ? imageLoad(geometry_texels, i) : geometry.words[i];
}

uvec4 Table(int i) {
    return GEOMETRY_TEXELS ? imageLoad(table_texels, i) : table.words[i];
}

uint ImageWord(int i) {
    return IMAGE_TEXELS ? imageLoad(image_texels, i).x : images.words[i];
}

// Loads one of the four vectors of a triangle's attributes. Vector 0 has the normals of its corners (UnpackUnitVector)
// and its material, with the bitangent's sign in the highest bit. Vectors 1 and 2 have the corners' texture
// coordinates, then the number of repeats of a map in one metre of the surface, and the slot of the corners. Vector 3
// has the tangents.
uvec4 Attribute(uint triangle, int vector) {
    return Geometry(triangles.attributes + 4 * int(triangle) + vector);
}

// Loads one of the three vectors of a material, given by the material word of a triangle's attributes. Vector 0 has
// albedo and emission, vector 1 albedo map and normal map. Vector 2 has a word of MATERIAL_ bits and of the levels of
// all maps, then the normal deviation, and the alpha mask. A map is the index of its first word among the words of
// images, and its width and height in 16 bits each; a map that is missing is white.
uvec4 Material(uint attribute_word, int vector) {
    return Table(3 * int(attribute_word & 0x7fffffffu) + vector);
}

#endif
