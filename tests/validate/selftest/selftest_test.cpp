#include "validate/selftest/selftest.h"

#include <gtest/gtest.h>

#include <cmath>

#include "validate/selftest/properties.h"

namespace backbend::validate {
namespace {

TEST(Selftest, KeepsTheWorstCaseAndWhereItWas) {
  Tally tally("solver", "p", "r", 1.0, "rad");
  tally.add(0.25, "first");
  tally.add(0.5, "second");
  tally.add(0.1, "third");
  EXPECT_EQ(tally.property().worst, 0.5);
  EXPECT_EQ(tally.property().where, "second");
  EXPECT_EQ(tally.property().cases, 3u);
  EXPECT_TRUE(tally.property().holds());
  EXPECT_EQ(tally.property().margin(), 2.0);
}

TEST(Selftest, APropertyHoldsUpToItsBoundAndNotBeyond) {
  Tally tally("solver", "p", "r", 1.0, "rad");
  tally.add(1.0, "at it");
  EXPECT_TRUE(tally.property().holds());
  tally.add(std::nextafter(1.0, 2.0), "past it");
  EXPECT_FALSE(tally.property().holds());
}

TEST(Selftest, WhatIsNoNumberStaysTheWorstAndDoesNotHold) {
  Tally tally("solver", "p", "r", 1.0, "rad");
  tally.add(0.5, "first");
  tally.add(std::nan(""), "broken");
  tally.add(0.7, "later");
  EXPECT_TRUE(std::isnan(tally.property().worst));
  EXPECT_EQ(tally.property().where, "broken");
  EXPECT_FALSE(tally.property().holds());
  EXPECT_EQ(tally.property().margin(), 0.0);
}

TEST(Selftest, NothingTriedIsNothingHeld) {
  EXPECT_FALSE(Tally("skin", "p", "r", 1.0, "").property().holds());
}

}  // namespace
}  // namespace backbend::validate
