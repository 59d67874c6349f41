// The parameters of one draw of the G-buffer pass.

layout(push_constant) uniform DrawBlock {
    mat4 world_to_clip;       // reversed depth, multiplied in f64 on the host
    vec4 albedo;              // linear; w: 0 for a surface that shows the sky
    vec4 turn;                // unit quaternion, from the mesh to the world
    float reflectivity;
    float roughness;
    float normal_deviation;   // 0: geometric normal, 1: normal map
    uint maps;                // NORMAL_MAP, ALPHA_MASK, ROUGHNESS_MAP, SINGLE_SIDED
    float emission;           // share of the albedo that is emitted; 0 for a surface that shows the sky
} draw;
