"""Trains the refiner, the small network that corrects the box of the robust tracker.

Modules in the order of the data: recordings, tracked, clips, crops, pairs and cutouts, samples, fit (network), weights, integers, report.
"""
