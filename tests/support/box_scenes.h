// The product's box scenes under the name that tests know them by.
#pragma once

#include "engine_client/scene/box_scenes.h"

namespace sweepstake::test_support {

using sweepstake::BoxScene;
using sweepstake::BoxSceneKinds;
using sweepstake::Random;

}  // namespace sweepstake::test_support
