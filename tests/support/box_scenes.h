// The product's box scenes under the name that tests know them by.
#pragma once

#include "engine_client/scene/box_scenes.h"

namespace sweepstake::test_support {

using sweepstake::BoxScene;
using sweepstake::BoxSceneKinds;
using Random = sweepstake::SequentialRandom;

}  // namespace sweepstake::test_support
