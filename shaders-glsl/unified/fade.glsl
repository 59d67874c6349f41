// The border fade of the thesis (4.2.9, Eq. 4.7), by the hit's place. Needs parameters.glsl.

float Fade(vec2 uv) {
    float boundary = length(uv - vec2(0.5)) * 2.0;
    float fade = 1.0 - clamp((boundary - unified.fade_start) / (unified.fade_end - unified.fade_start), 0.0, 1.0);
    return unified.fade != 0 ? fade : 1.0;
}
