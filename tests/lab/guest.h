#pragma once

// Everything that a test in a guest of the laboratory (run_guest) can use.

// IWYU pragma: begin_exports
#include "tests/lab/can_bus.h"
#include "tests/lab/gpio_bank.h"
#include "tests/lab/raw_can.h"
#include "tests/lab/shell.h"
#include "tests/lab/slcan.h"
#include "tests/lab/uart.h"
// IWYU pragma: end_exports
