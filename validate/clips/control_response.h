#pragma once
#include <optional>

#include "skin/anatomy/anatomy.h"
#include "skin/clip/clip.h"
#include "validate/clips/clip_body.h"
#include "validate/measure/measure.h"

namespace backbend::validate {

/// The part of a body channel's angle that arrives at the chest, in a sweep of this channel alone:
/// read where the channel is nearest to 30 degrees from its value nearest to rest, as the sum
/// of the turns of the spine's joints from hips to chest, each against the one below, between those
/// two frames: 30 degrees are far from every branch, and the sum does not wrap. Axes are those of
/// the body at rest: left for extension and flexion, the line from hips to chest for twist, the one
/// across both for side. Side and twist have no right sign: their share is never negative.
///
/// Nothing where the clip records no such channel, a sweep moves several or moves its one by less
/// than 5 degrees, or the skeleton has no known left.
std::optional<ChannelResponse> control_response(const skin::Clip& clip,
                                                const skin::ClipSweep& range,
                                                const skin::Anatomy& anatomy,
                                                const skin::Character& character,
                                                const ClipBody& body);

/// How far the spine is bent, in degrees from hips to chest, in the frame whose recorded controls
/// are all within half a degree of 0, where it is bent by 5 degrees or more: the motion was not
/// written from the rest pose. 0 where it was, or where no frame has all controls at rest.
double bend_at_rest(const skin::Clip& clip, const skin::Anatomy& anatomy, const ClipBody& body);

}  // namespace backbend::validate
