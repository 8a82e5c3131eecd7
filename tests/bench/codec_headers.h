/// Headers of every codec, compiled once before them: they are two thirds of the time of a codec.
#include <algorithm>

#include "transports/codecs/framed_decoder.h"
#include "transports/codecs/protocol.h"
