#pragma once

#include <gtest/gtest.h>

#include "transports/links/link.h"

namespace tribus::test {

/// Expects a link that only writes: nothing wakes its reader, and a read leaves nothing of before.
inline void expect_nothing_to_read(ByteLink& link) {
    Reception reception;
    reception.count = 9;
    reception.full = true;
    EXPECT_EQ(link.read(reception), ReadStatus::nothing);
    EXPECT_EQ(reception.count, 0U);
    EXPECT_FALSE(reception.full);
    EXPECT_EQ(link.descriptor(), -1);
}

}  // namespace tribus::test
