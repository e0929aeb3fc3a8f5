/* Stands in for Zephyr's kernel in the test `.ci/release boards`. */
#pragma once
#include <stdio.h>
#define printk printf
#define K_FOREVER 0
