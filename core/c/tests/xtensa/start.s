# Start-up code and exception vectors for QEMU's machine `sim` with the core dc233c: it calls libc.c, which calls main.
#
# The core has what the ESP32 has of the instruction set, but MULUH and MULSH: the vector of illegal instructions computes them.

	.macro simcall # QEMU serves it: a2 says which call
	.byte 0x00, 0x51, 0x00
	.endm

	.section .vectors, "ax"
# A frame of eight registers goes to the stack, and comes back from it.
	.org 0x80
	s32e	a0, a9, -16
	l32e	a0, a1, -12
	s32e	a1, a9, -12
	s32e	a2, a9, -8
	s32e	a3, a9, -4
	s32e	a4, a0, -32
	s32e	a5, a0, -28
	s32e	a6, a0, -24
	s32e	a7, a0, -20
	rfwo
	.org 0xc0
	l32e	a0, a9, -16
	l32e	a1, a9, -12
	l32e	a2, a9, -8
	l32e	a7, a1, -12
	l32e	a3, a9, -4
	l32e	a4, a7, -32
	l32e	a5, a7, -28
	l32e	a6, a7, -24
	l32e	a7, a7, -20
	rfwu
	.org 0x300
	wsr	a0, excsave1
	j	exception
	.org 0x340
	wsr	a0, excsave1
	j	exception
	.org 0x3c0
	j	fatal

	.org 0x400
# Registers are kept from address 0x600: a0 to a15, the place of the instruction, the processor's state. Then the number of computed instructions.
exception:
	movi	a0, 0x600
	s32i	a2, a0, 8
	s32i	a3, a0, 12
	rsr	a2, epc1
	s32i	a2, a0, 64
	rsr	a2, ps
	s32i	a2, a0, 68
# An instruction that writes to a register of an older frame would first have sent that frame to the stack. So does this one, for all of them.
	movi	a3, -17
	and	a2, a2, a3
	movi	a3, 15
	or	a2, a2, a3
	wsr	a2, ps
	rsync
	or	a15, a15, a15
	l32i	a2, a0, 68
	wsr	a2, ps
	rsync
	s32i	a1, a0, 4
	s32i	a4, a0, 16
	s32i	a5, a0, 20
	s32i	a6, a0, 24
	s32i	a7, a0, 28
	s32i	a8, a0, 32
	s32i	a9, a0, 36
	s32i	a10, a0, 40
	s32i	a11, a0, 44
	s32i	a12, a0, 48
	s32i	a13, a0, 52
	s32i	a14, a0, 56
	s32i	a15, a0, 60
	rsr	a1, excsave1
	s32i	a1, a0, 0
# The instruction's bytes are t:0, r:s, and a2 for MULUH or b2 for MULSH: r = upper half of s * t.
	l32i	a2, a0, 64
	l8ui	a3, a2, 0
	l8ui	a4, a2, 1
	l8ui	a5, a2, 2
	extui	a6, a3, 0, 4
	bnez	a6, fatal
	movi	a6, 0xa2
	beq	a5, a6, 1f
	movi	a6, 0xb2
	beq	a5, a6, 1f
	j	fatal
1:	extui	a8, a3, 4, 4
	addx4	a8, a8, a0
	l32i	a8, a8, 0
	extui	a7, a4, 0, 4
	addx4	a7, a7, a0
	l32i	a7, a7, 0
	extui	a9, a7, 0, 16
	extui	a10, a7, 16, 16
	extui	a11, a8, 0, 16
	extui	a12, a8, 16, 16
	mull	a13, a9, a11
	mull	a14, a9, a12
	mull	a15, a10, a11
	mull	a12, a10, a12
	extui	a13, a13, 16, 16
	extui	a1, a14, 0, 16
	add	a13, a13, a1
	extui	a1, a15, 0, 16
	add	a13, a13, a1
	extui	a14, a14, 16, 16
	extui	a15, a15, 16, 16
	extui	a13, a13, 16, 16
	add	a12, a12, a14
	add	a12, a12, a15
	add	a12, a12, a13
	movi	a6, 0xa2
	beq	a5, a6, 3f
	bgez	a7, 2f
	sub	a12, a12, a8
2:	bgez	a8, 3f
	sub	a12, a12, a7
3:	extui	a4, a4, 4, 4
	addx4	a4, a4, a0
	s32i	a12, a4, 0
	addi	a2, a2, 3
	wsr	a2, epc1
	l32i	a2, a0, 72
	addi	a2, a2, 1
	s32i	a2, a0, 72
	l32i	a1, a0, 4
	l32i	a2, a0, 8
	l32i	a3, a0, 12
	l32i	a4, a0, 16
	l32i	a5, a0, 20
	l32i	a6, a0, 24
	l32i	a7, a0, 28
	l32i	a8, a0, 32
	l32i	a9, a0, 36
	l32i	a10, a0, 40
	l32i	a11, a0, 44
	l32i	a12, a0, 48
	l32i	a13, a0, 52
	l32i	a14, a0, 56
	l32i	a15, a0, 60
	l32i	a0, a0, 0
	rfe
fatal: # exit(99)
	movi	a2, 1
	movi	a3, 99
	simcall

	.section .text._start, "ax"
	.global _start
_start:
	movi	a2, 1
	wsr	a2, windowstart
	movi	a2, 0
	wsr	a2, windowbase
	rsync
	movi	a2, 1
	slli	a2, a2, 13
	wsr	a2, vecbase
	movi	a1, 1
	slli	a1, a1, 26
	movi	a2, 1
	slli	a2, a2, 18 # frames are kept in registers
	addi	a2, a2, 15 # no interrupts
	wsr	a2, ps
	rsync
	movi	a0, 0
	movi	a8, run
	callx8	a8
1:	j	1b

# host_call(call, a, b, c): has QEMU serve a call
	.text
	.global host_call
	.p2align 2
host_call:
	entry	a1, 32
	simcall
	retw.n
