// What is known of a picture before its pipeline is made, so that a compiler leaves out what the picture does not need.
// Twin of src/render/known.rs.
#ifndef RENDER_KNOWN
#define RENDER_KNOWN

// Bit 0: some draw is its own reference; bit 1: some draw is looked up.
layout(constant_id = 0) const uint known_correspondence = 3u;
// The line, layout and record of all tables, or IGT_ANY.
layout(constant_id = 1) const uint known_line = 255u;
layout(constant_id = 2) const uint known_layout = 255u;
layout(constant_id = 3) const uint known_record = 255u;
// Whether no draw is deformed.
layout(constant_id = 4) const bool known_rigid = false;
// Shards that texels lie in, at most.
layout(constant_id = 5) const uint known_shards = 4u;
// The texture slots that some material uses, and whether the triangles' records hold the uv of all of them.
layout(constant_id = 6) const uint known_slots = 31u;
layout(constant_id = 7) const bool known_recorded = false;
// Whether an attribute is shown in place of base colour.
layout(constant_id = 8) const bool known_shown = false;
// Whether that is a solid texture, a 3-D image or a function.
layout(constant_id = 17) const bool known_solid = false;
// Whether something was filtered beforehand.
layout(constant_id = 18) const bool known_prefiltered = false;
// How a pixel gathers the reference (FILTER_*).
layout(constant_id = 9) const uint known_filter = 0u;
#define IGT_KNOWN_SLOTS known_slots
#define IGT_KNOWN_SOLID known_solid
#define IGT_KNOWN_RECORDED known_recorded

#endif
