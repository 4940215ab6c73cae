"""Tests of jacobi."""
